"""Loading and saving the calibration file of a rig, and what is to be said of one that was read."""

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import CalibrationWarning, InputError
from stereorecal.geometry import (
    StereoRig,
    checked_rig,
    checked_unit,
    described_turns,
    doubt_of_length,
    fitted_to,
    whole_size,
)
from stereorecal.io._atomic import write_files
from stereorecal.io._read_files import AnyPath
from stereorecal.io._strict_json import parse_json
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._format_list import named
from stereorecal.io.formats._matrix_search import calibration_template
from stereorecal.io.formats._read_rig import as_in_file, checked_cameras, read_files, rig_in
from stereorecal.io.formats._rig_file import (
    KEY,
    PriorData,
    RigFile,
    file_of,
    own_prior,
    prior_place,
    prior_text,
    with_prior,
)
from stereorecal.io.formats._stereorecal import calibration_of, calibration_text
from stereorecal.io.formats._write_rig import chosen_format, texts_of

_FAR = 0.15  # of the width or height: principal points of cameras whose images are whole lie nearer to the middle


def warn_of_file(path: AnyPath, *rigs: StereoRig | None, sized: bool = True) -> None:
    """Warn, once for what `path` holds, of a baseline whose unit was inferred, or whose length speaks of another unit
    than its own; of turned images; and of principal points far from the middle of images, where the user and not the
    file says the size of these. To be called by the function that users call: the warning points at their line.

    Args:
        sized: whether the size may have come from the user.
    """
    known = [rig for rig in rigs if rig is not None]
    doubts = [_doubt_of_size] if sized else []
    said = [next(filter(None, map(doubt, known)), None) for doubt in (*doubts, _doubt_of_unit)]
    for turns in {rig.turns for rig in known if any(rig.turns)}:
        said.append(
            f"{described_turns(turns)} when they are read, and the calibration with them; files stay as they are."
        )
    for message in filter(None, said):
        warnings.warn(f"{path}: {message}", CalibrationWarning, stacklevel=3)


def _doubt_of_size(rig: StereoRig) -> str | None:
    source = file_of(rig)
    if source is None or source.hints.size is None:
        return None
    for camera in (rig.left, rig.right):
        place, size = np.asarray(camera.matrix)[:2, 2], np.array(camera.size)
        if (np.abs(place + 0.5 - size / 2.0) > _FAR * size).any() and not _states_size(source):
            return (
                f"the file has no image size, and its principal point ({place[0]:.0f}, {place[1]:.0f}) is far from the "
                f"middle of images of {size[0]}x{size[1]}; if it is for images of another size, give that size, and "
                "then resize or crop the rig (rig.resized, rig.cropped)."
            )
    return None


def _states_size(source: RigFile) -> bool:
    """Whether a file is not for images of any size that is said."""
    assert source.hints.size is not None
    other = source.hints.size[0] + 1, source.hints.size[1] + 1
    try:
        rig = rig_in(source.documents, named(source.format), source.unit, replace(source.hints, size=other))
    except InputError:
        return True
    return rig.left.size != other


def _doubt_of_unit(rig: StereoRig) -> str | None:
    length, source = float(rig.baseline), rig.source
    message = doubt_of_length(length, "m" if source is None else source.unit)
    if message is None and source is not None and source.inferred:
        return (
            f"the file has no unit; its translation is taken to be in {source.unit}, a baseline of {length:.3g} m: say "
            f"unit='{source.unit}' (--unit {source.unit}) if that is right, or another unit if it is not."
        )
    return message


_MOST_FILES = 12  # one for each matrix, and some beside


def load_rig(
    path: AnyPath | Sequence[AnyPath],
    right: AnyPath | None = None,
    *,
    format: str | None = None,
    unit: str | None = None,
    size: tuple[int, int] | None = None,
    cameras: tuple[str, str] | None = None,
) -> StereoRig:
    """The rig in a calibration file of any format of `docs/data.md`; it remembers the file, for `save_rig`. Where its
    cameras stand one above the other, or one is upside down, what matches images turns it, and them:
    `StereoRig.side_by_side`.

    Args:
        path: the file; a folder that holds one; or the left camera's file, where each camera has its own, alone or
            with the right one's, as `save_rig` takes them; or all files, where each matrix has its own.
        right: the right camera's file (or the extrinsics, where OpenCV's sample wrote them apart).
        format: name of the format, such as "kalibr"; by default it is recognised.
        unit: "m", "cm", "mm" or "in", of the lengths in the file; by default that of the format, or, if it has none
            (OpenCV, BoofCV), inferred from the baseline.
        size: (width, height) of the images, for files that say none.
        cameras: names of the left and the right camera where a file has more than two, such as ("cam2", "cam3"), or
            where the first one is the right one: ("cam1", "cam0"), or of any format ("right", "left").

    Raises:
        InputError: naming the file, if it cannot be read or does not hold a valid calibration; naming the formats that
            are known, if it is none of them.
        UnsupportedModelError: if the model of a lens is not known.

    Warns:
        CalibrationWarning: if the unit was inferred from the baseline, or the baseline is longer than 5 m or shorter
            than 5 mm, as of a rig in other units; or if the principal points are far from the middle of
            images whose size the file does not say.
    """
    paths = [*_paths(path), *([] if right is None else [Path(right)])]
    if not 1 <= len(paths) <= _MOST_FILES:
        raise InputError(f"{len(paths)} calibration files were given; give one, or two where each camera has its own.")
    if len(paths) > 2 and len(set(paths)) < len(paths):
        raise InputError(f"{len(paths)} calibration files were given, and one of them twice; give each once.")
    rig = read_files(paths, format, unit, Hints(size=size, cameras=checked_cameras(cameras)))
    if size is not None and rig.left.size != (size := whole_size(size)):
        wide, high = rig.left.size
        raise InputError(
            f"{paths[0]}: the file is for images of {wide}x{high}, and the size that was given is {size[0]}x{size[1]}; "
            f"leave size out, and {fitted_to(rig.left.size, size)}."
        )
    warn_of_file(" and ".join(map(str, paths)), rig)
    return rig


def save_rig(
    rig: StereoRig,
    path: AnyPath | Sequence[AnyPath],
    info: Mapping[str, Any] | None = None,
    overwrite: bool = False,
    *,
    format: str | None = None,
    template: AnyPath | Sequence[AnyPath] | None = None,
    unit: str | None = None,
    prior: PriorData | None = None,
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
        prior: the prior of the next repair, such as `solution.prior`; default the one in the file that the rig came
            from, if the rig is unchanged. A calib.json has a key for it; any other format gets the file
            NAME.prior.json beside the (left camera's) file: both are written, or none.

    Raises:
        InputError: if a file exists already, the place cannot be written to, the name contradicts the format, the
            format has another unit, or cannot hold the rig: the message names one that can. Nothing is written then.

    Warns:
        CalibrationWarning: if the unit of the template was inferred from its baseline.
    """
    checked_rig(rig)
    checked_unit(unit)
    paths = _paths(path)
    if len({place.resolve() for place in paths}) < len(paths):
        raise InputError(f"{paths[0]}: both cameras' files are the same one; give two names.")
    if template is None:
        source = file_of(rig)
    else:
        template_rig = _read_template(template, unit, rig)
        source = file_of(template_rig)
        warn_of_file(str(template), template_rig, sized=False)
    texts = list(texts_of(rig, paths, source, format, unit))
    if prior is not None:
        prior.check(rig)
    known = own_prior(rig) if prior is None else prior.as_dict()
    name = chosen_format(paths, source, format).name
    prior_path = prior_place(paths, name)
    if name == "stereorecal":
        texts[0] = with_prior(_with_info(texts[0], info or {}), known)
    contents = dict(zip(paths, texts, strict=True))
    if known is not None and prior_path is not None:
        contents[prior_path] = prior_text(known)
    for place in paths:
        if not place.parent.is_dir():  # before the first of two is written
            raise InputError(f"{place}: cannot be written, there is no such folder; choose another place.")
    write_files({place: text.encode() for place, text in contents.items()}, replace=overwrite)


def check_savable(
    rig: StereoRig, path: AnyPath | Sequence[AnyPath], *, format: str | None = None, unit: str | None = None
) -> None:
    """All that `save_rig` refuses but for files that exist; nothing is written.

    Raises:
        InputError: as `save_rig`.
    """
    texts_of(rig, _paths(path), file_of(rig), format, unit)


def unit_read(rig: StereoRig) -> str | None:
    """The unit of lengths in the file that a rig came from; None if it was inferred, or for a rig from nowhere."""
    source = file_of(rig)
    return None if source is None or source.inferred else source.unit


def unsaid_unit(rig: StereoRig | None, path: AnyPath | Sequence[AnyPath], *, format: str | None = None) -> str | None:
    """The unit of lengths in what `save_rig` writes, where the format says none; None where it says one."""
    source = None if rig is None else file_of(rig)
    chosen = chosen_format(_paths(path), source, format)
    own = source.unit if source is not None and source.format == chosen.name else "m"
    return own if chosen.unit is None else None


def prior_beside(rig: StereoRig, path: AnyPath | Sequence[AnyPath], *, format: str | None = None) -> Path | None:
    """The file that `save_rig` writes beside a calibration for its prior; None where it writes none."""
    paths = _paths(path)
    return prior_place(paths, chosen_format(paths, file_of(rig), format).name)


def calibration_json(rig: StereoRig, prior: PriorData | None = None) -> str:
    """A rig as a calib.json, with what is known of it."""
    taken = as_in_file(rig, exchanged=False)
    text = calibration_text(calibration_of(taken, taken.left.size))
    return text if prior is None else with_prior(text, prior.as_dict())


def save_template(paths: Sequence[AnyPath], path: AnyPath, *, overwrite: bool = False) -> None:
    """Write a calib.json to be filled in, with the arrays of calibration files of no known form beside.

    Raises:
        InputError: if a file is missing, or the place cannot be written to.
    """
    write_files({Path(path): calibration_template(paths).encode()}, replace=overwrite)


def calibration_files(rig: StereoRig | None) -> list[Path]:
    """The files that a rig came from; none if it came from nowhere."""
    source = None if rig is None else file_of(rig)
    return [] if source is None else [Path(document.name) for document in source.documents]


def _paths(path: AnyPath | Sequence[AnyPath]) -> list[Path]:
    return [Path(path)] if isinstance(path, str | os.PathLike) else [Path(each) for each in path]


def _read_template(template: AnyPath | Sequence[AnyPath], unit: str | None, rig: StereoRig) -> StereoRig:
    """The rig in a template; lengths in one that says no unit are as in the rig's own file of that format."""
    paths, hints, own = _paths(template), Hints(size=rig.sizes_taken[0]), file_of(rig)
    template_rig = read_files(paths, unit=unit, hints=hints)
    found = file_of(template_rig)
    if own is not None and found is not None and found.inferred and found.format == own.format:
        return read_files(paths, unit=own.unit, hints=hints)
    return template_rig


def _with_info(text: str, info: Mapping[str, Any]) -> str:
    """A calib.json with other keys, which come first; byte for byte, if it has them already."""
    content, info = parse_json(text), {key: item for key, item in info.items() if key != KEY}
    return text if info.keys() <= content.keys() else calibration_text({**info, **content})
