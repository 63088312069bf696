"""From a rig to files: a copy of the calibration file that it came from, or a new one, and its prior; and rectifying
maps."""

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import InputError, checked_choice
from stereorecal.geometry import (
    METRES,
    PINHOLE,
    AnyView,
    StereoRig,
    checked_rig,
    rectification,
    same_camera,
    same_rig,
)
from stereorecal.io._atomic import write_bytes, write_files
from stereorecal.io._read_files import AnyPath, about
from stereorecal.io._strict_json import parse_json
from stereorecal.io.formats import _opencv, _stereorecal
from stereorecal.io.formats._format import Documents, Format, Hints
from stereorecal.io.formats._load_rig import paths_of, read_files, warn_of_file
from stereorecal.io.formats._read_rig import as_in_file, at_common_size, chosen_cameras, named, rig_in, scaled
from stereorecal.io.formats._rig_file import (
    KEY,
    RigFile,
    file_of,
    own_prior,
    prior_place,
    with_prior,
)
from stereorecal.io.formats.text._document import Syntax, document

Paths = AnyPath | Sequence[AnyPath]


def save_rig(
    rig: StereoRig,
    path: Paths,
    info: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    *,
    format: str | None = None,
    template: Paths | None = None,
    unit: str | None = None,
    prior: Any = None,
) -> None:
    """Write a rig into a copy of the file that it came from, whole or not at all: what was not estimated stays as it
    was there, what is derived is computed anew. A rig from nowhere, or in another format, becomes a new file.

    `load_rig` returns the same extrinsics to within 1e-12.

    Args:
        path: a file, or two where each camera has its own; its ending must fit the format.
        info: other keys of a calib.json, such as `Scene.info`; those that describe the rig are replaced.
        overwrite: whether existing files may be replaced.
        format: name of the format; by default that of the template, or for a rig from nowhere a calib.json, or OpenCV's
            where the name ends in .yaml, .yml or .xml.
        template: a calibration file (or two) to write into, in place of the one that the rig came from.
        unit: "m", "cm", "mm" or "in": of a template, by default that of its format, or, if it has none, that of the
            file that the rig came from, if its format is the same, else inferred from the template's baseline; or of a
            new file whose format has none, by default metres.
        prior: the `SavedPrior` of the next repair, such as `solution.prior`; default the one in the file that the rig
            came from, if the rig is unchanged. A calib.json has a key for it; any other format gets the file
            NAME.prior.json beside the (left camera's) file: both are written, or none.

    Raises:
        InputError: if a file exists already, the place cannot be written to, the name contradicts the format, the
            format has another unit, or cannot hold the rig: the message names one that can. Nothing is written then.

    Warns:
        CalibrationWarning: if the unit of the template was inferred from its baseline.
    """
    checked_rig(rig)
    paths, source = paths_of(path), file_of(rig)
    if template is not None:
        template_rig = _read_template(template, unit, rig)
        source = file_of(template_rig)
        warn_of_file(str(template), template_rig, sized=False)
    texts = list(_texts_of(rig, paths, source, format, unit))
    if prior is not None:
        prior.check(rig)
    known = own_prior(rig) if prior is None else prior.as_dict()
    name = _chosen_format(paths, source, format).name
    prior_path = prior_place(paths, name)
    if name == _stereorecal.NAME:
        content, others = parse_json(texts[0]), {key: item for key, item in (info or {}).items() if key != KEY}
        # Byte for byte, if it has these keys already.
        text = texts[0] if others.keys() <= content.keys() else _stereorecal.calibration_text({**others, **content})
        texts[0] = with_prior(text, known)
    contents = dict(zip(paths, texts, strict=True))
    if known is not None and prior_path is not None:
        contents[prior_path] = json.dumps(known, allow_nan=False) + "\n"
    write_files({place: text.encode() for place, text in contents.items()}, replace=overwrite)


def check_savable(rig: StereoRig, path: Paths, *, format: str | None = None, unit: str | None = None) -> None:
    """Refuse all that `save_rig` refuses, with its InputErrors, but for files that exist; nothing is written."""
    _texts_of(rig, paths_of(path), file_of(rig), format, unit)


def unit_read(rig: StereoRig) -> str | None:
    """The unit of lengths in the file that a rig came from; None if it was inferred, or for a rig from nowhere."""
    source = file_of(rig)
    return None if source is None or source.inferred else source.unit


def unsaid_unit(rig: StereoRig | None, path: Paths, *, format: str | None = None) -> str | None:
    """The unit of lengths in what `save_rig` writes, where the format says none; None where it says one."""
    source = file_of(rig)
    chosen = _chosen_format(paths_of(path), source, format)
    own = source.unit if source is not None and source.format == chosen.name else "m"
    return own if chosen.unit is None else None


def prior_beside(rig: StereoRig, path: Paths) -> Path | None:
    """The file that `save_rig` writes beside a calibration for its prior; None where it writes none."""
    paths = paths_of(path)
    return prior_place(paths, _chosen_format(paths, file_of(rig), None).name)


def calibration_json(rig: StereoRig, prior: Any = None) -> str:
    """A rig as a calib.json, with the `SavedPrior` of its next repair."""
    taken = as_in_file(rig, exchanged=False)
    text = _stereorecal.calibration_text(_stereorecal.calibration_of(taken))
    return text if prior is None else with_prior(text, prior.as_dict())


def calibration_files(rig: StereoRig | None) -> list[Path]:
    """The files that a rig came from; none if it came from nowhere."""
    source = file_of(rig)
    return [] if source is None else [Path(document.name) for document in source.documents]


def _read_template(template: Paths, unit: str | None, rig: StereoRig) -> StereoRig:
    """The rig in a template; lengths in one that says no unit are as in the rig's own file of that format."""
    paths, hints, own = paths_of(template), Hints(size=rig.sizes_taken[0]), file_of(rig)
    template_rig = read_files(paths, unit=unit, hints=hints)
    found = file_of(template_rig)
    if own is not None and found is not None and found.inferred and found.format == own.format:
        return read_files(paths, unit=own.unit, hints=hints)
    return template_rig


def save_maps(rig: StereoRig, path: AnyPath, overwrite: bool = False, view: AnyView = None) -> None:
    """Write what `sr.rectification(rig, view)` holds as an .npz, whole or not at all: `left_x`, `left_y`, `right_x`,
    `right_y` (h, w) float32, as `cv2.remap` takes them, `R1`, `R2`, `size` (width, height), `projection` by name,
    `focal`, and `centre_left`, `centre_right`, `centre_row` of the rectified images, pixels; of a pinhole also `P1`,
    `P2` and `Q`.

    Raises:
        InputError: if the file exists already, the place cannot be written to, or the view makes no sense.
    """
    made = rectification(rig, view)
    (left_x, left_y), (right_x, right_y) = made.maps
    arrays: dict[str, Any] = {"left_x": left_x, "left_y": left_y, "right_x": right_x, "right_y": right_y}
    arrays |= {"size": np.array(made.size), "R1": made.R1, "R2": made.R2, "projection": np.array(made.view.projection)}
    for name in ("focal", "centre_left", "centre_right", "centre_row"):
        arrays[name] = np.array(float(getattr(made.view, name)))
    arrays |= {"P1": made.P1, "P2": made.P2, "Q": made.Q} if made.view.projection == PINHOLE else {}
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    write_bytes(path, file.getvalue(), replace=overwrite)


# --- the texts


def _texts_of(
    rig: StereoRig, paths: Sequence[Path], source: RigFile | None, format: str | None, unit: str | None
) -> tuple[str, ...]:
    """What is to be written for a rig; reading it gives the rig back.

    It is written into the source, if the format is its own; else `unit` is that of a format that says none.
    """
    if len({place.resolve() for place in paths}) < len(paths):
        raise InputError(f"{paths[0]}: both cameras' files are the same one; give two names.")
    for place in paths:
        if not place.parent.is_dir():
            raise InputError(f"{place}: cannot be written, there is no such folder; choose another place.")
    chosen = _chosen_format(paths, source, format)
    if unit is not None:
        checked_choice(unit, METRES, "unit")
    before = rig
    if source is not None:
        before = rig_in(source.documents, named(source.format), source.unit, source.hints).turned(rig.turns)
        rig = _at_own_sizes(rig, before)
    own = source if source is not None and source.format == chosen.name else None
    syntax = _syntax_for(paths, chosen, own)
    into = own if own is not None and own.documents[0].syntax is syntax else None
    stated = chosen.unit if into is None else into.unit
    with about(" and ".join(map(str, paths))):
        if stated is not None and unit not in (None, stated):
            raise InputError(f"lengths of this {chosen.name} file are in {stated}, not in {unit}; leave the unit out.")
        if into is not None:
            return _into(rig, before, chosen, into)
        taken = as_in_file(rig, exchanged=False)
        blanks = tuple(document("a new file", text, syntax) for text in chosen.blank(taken, syntax))
        hints = Hints(size=taken.left.size, rectified=False)
        return _checked(rig, chosen, blanks, hints, stated or unit or (own.unit if own is not None else "m"))


def _at_own_sizes(rig: StereoRig, own: StereoRig) -> StereoRig:
    """A rig at the common size of cameras of two sizes, with these; a camera that has not changed is the same."""
    seen = at_common_size(own)
    if seen is own or not rig.left.size == rig.right.size == seen.left.size:
        return rig
    left, right = (
        before if same_camera(at_common, now) else now.resized(before.size)
        for before, at_common, now in ((own.left, seen.left, rig.left), (own.right, seen.right, rig.right))
    )
    return replace(rig, left=left, right=right)


def _chosen_format(paths: Sequence[Path], source: RigFile | None, format: str | None) -> Format:
    """The given format, or that of the source if it is written, or the usual one for such a name."""
    if format is not None:
        chosen = named(format)
        if chosen.syntax:
            return chosen
        raise InputError(
            f"{chosen.name} ({chosen.about}) is read, not written; write the rig as opencv, kalibr or stereorecal "
            "instead: save_rig(…, format=…), --to of convert."
        )
    if source is not None and named(source.format).syntax:
        return named(source.format)
    match paths[0].suffix.lower():
        case "" | ".json":
            return _stereorecal.FORMAT
        case ".yaml" | ".yml" | ".xml":
            return _opencv.FORMAT
    raise InputError(
        f"{paths[0]}: the file name's ending does not identify the format; say which with format=, on the command "
        "line --to."
    )


def _syntax_for(paths: Sequence[Path], format: Format, own: RigFile | None) -> Syntax:
    """The syntax of what is written under a name, for a rig from a file of the format or from elsewhere."""
    files = len(own.documents) if own else format.files
    if len(paths) != files:
        few = {1: "one file; give one name", 2: "two files, left and right; give two names"}
        many = f"{files} files, as it was read; give as many names, or another format, such as stereorecal"
        raise InputError(f"{' and '.join(map(str, paths))}: {format.name} is written as {few.get(files, many)}.")
    usual = own.documents[0].syntax if own else next(iter(format.syntax.values()))
    endings = {path.suffix.lower() for path in paths} - {""}
    first, *others = {format.syntax.get(ending) for ending in endings} or {usual}
    if first is None or others:
        wanted = " or ".join(format.syntax)
        raise InputError(
            f"{paths[0]}: the ending contradicts what is to be written ({format.name}: {format.about}); give a name "
            f"ending in {wanted}, or another format with format= (--to of convert)."
        )
    return first


def _into(rig: StereoRig, before: StereoRig, format: Format, source: RigFile) -> tuple[str, ...]:
    """The texts of the source, which had another rig before, with what has changed."""
    cameras = ((before.left, rig.left), (before.right, rig.right))
    for old, new in cameras:
        if old.size != new.size:
            wide, high = old.size
            raise InputError(
                f"the file is for images of {wide}x{high}, and the rig for {new.size[0]}x{new.size[1]}; write "
                f"`rig.resized(({wide}, {high}))` if it was scaled, or a new file: "
                "`dataclasses.replace(rig, source=None)`, no template."
            )
        if old.model != new.model:
            raise InputError(
                f"the file has a lens of the model {old.model!r}, and the rig one of {new.model!r}; write a new file: "
                "`dataclasses.replace(rig, source=None)`, no template."
            )
    sides = [side for side, (old, new) in enumerate(cameras) if not same_camera(old, new)]
    if not sides and np.array_equal(before.extrinsics, rig.extrinsics):
        return tuple(document.text for document in source.documents)
    return _checked(rig, format, source.documents, source.hints, source.unit, sides)


def _checked(
    rig: StereoRig, format: Format, old: Documents, hints: Hints, unit: str, sides: Sequence[int] = (0, 1)
) -> tuple[str, ...]:
    """The texts of documents with the numbers of a rig, and of the cameras of these sides, which were read again."""
    if format.one_size and rig.left.size != rig.right.size:
        raise InputError(
            f"{format.name} has one size of images for both cameras, and these have two; write the rig as kalibr, ros "
            "or basalt instead."
        )
    asked, exchanged = chosen_cameras(format, old, hints)
    taken = as_in_file(scaled(rig, 1.0 / METRES[unit]), exchanged)
    changed = {side: (taken.left, taken.right)[side] for side in (1 - side if exchanged else side for side in sides)}
    values = format.write(taken, old, asked, changed)
    texts = tuple(document.with_values(new) for document, new in zip(old, values, strict=True))
    written = tuple(document(o.name, text, o.syntax) for o, text in zip(old, texts, strict=True))
    if not same_rig(rig, rig_in(written, format, unit, hints)):
        raise InputError(
            f"the {format.name} file cannot take this rig without a loss; write it in another format, such as opencv."
        )
    return texts
