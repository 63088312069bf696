"""From a rig to the texts of files."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import METRES, StereoRig, checked_unit, same_camera, same_rig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Format, Hints, Target
from stereorecal.io.formats._format_list import named, usual
from stereorecal.io.formats._read_rig import as_in_file, at_common_size, chosen_cameras, rig_in, scaled
from stereorecal.io.formats._rig_file import RigFile
from stereorecal.io.formats.text._document import Syntax, document


def texts_of(
    rig: StereoRig, paths: Sequence[Path], source: RigFile | None, format: str | None, unit: str | None = None
) -> tuple[str, ...]:
    """What is to be written for a rig; reading it gives the rig back.

    Args:
        paths: one, or those of the left and the right camera.
        source: the file to write into, if the format is its own; all that was not estimated stays.
        format: name; default: that of the source, or the usual one for such a name of a file.
        unit: of a new file whose format says none; default: that of the source, if the format is its own, else metres.

    Raises:
        InputError: if the name of a file contradicts the format, the format takes another number of files, it cannot
            hold the rig, or is in another unit.
    """
    chosen = chosen_format(paths, source, format)
    checked_unit(unit)
    if source is not None and source.hints.common_size:
        source = replace(source, hints=replace(source.hints, common_size=False))
        own_sizes = rig_in(source.documents, named(source.format), source.unit, source.hints)
        rig = _at_own_sizes(rig, own_sizes.turned(rig.turns))
    own = source if source is not None and source.format == chosen.name else None
    syntax = _syntax_for(paths, chosen, own)
    into = own if own is not None and own.documents[0].syntax is syntax else None
    stated = chosen.unit if into is None else into.unit
    with about(" and ".join(map(str, paths))):
        if stated is not None and unit not in (None, stated):
            raise InputError(f"lengths of this {chosen.name} file are in {stated}, not in {unit}; leave the unit out.")
        if into is not None:
            return _into(rig, chosen, into)
        taken = as_in_file(rig, exchanged=False)
        blanks = tuple(document("a new file", text, syntax) for text in chosen.blank(taken, syntax))
        target = Target(blanks, hints=Hints(size=taken.left.size, rectified=False))
        return _checked(rig, chosen, target, stated or unit or (own.unit if own is not None else "m"))


def _at_own_sizes(rig: StereoRig, own: StereoRig) -> StereoRig:
    """A rig at its common size, with the sizes of `own`, which it was; a camera that has not changed is the same."""
    if rig.left.size != rig.right.size:
        return rig
    seen = at_common_size(own)
    left, right = (
        before if same_camera(at_common, now) else now.resized(before.size)
        for before, at_common, now in ((own.left, seen.left, rig.left), (own.right, seen.right, rig.right))
    )
    return replace(rig, left=left, right=right)


def chosen_format(paths: Sequence[Path], source: RigFile | None, format: str | None) -> Format:
    """The given format, or that of the source if it is written, or the usual one for such a name."""
    if format is not None:
        chosen = named(format)
        if chosen.syntax:
            return chosen
        raise InputError(
            f"{chosen.name} ({chosen.about}) is read, not written; write the rig as opencv, kalibr or stereorecal "
            "instead: save_rig(…, format=…), --to of convert."
        )
    own = named(source.format) if source is not None else None
    return own if own is not None and own.syntax else usual(paths[0])


def _syntax_for(paths: Sequence[Path], format: Format, own: RigFile | None) -> Syntax:
    """The syntax of what is written under a name, for a rig from a file of the format or from elsewhere."""
    files = len(own.documents) if own else format.files
    if len(paths) != files:
        two = "two files, left and right; give two names"
        many = f"{files} files, as it was read; give as many names, or another format, such as stereorecal"
        wanted = "one file; give one name" if files == 1 else two if files == 2 else many
        raise InputError(f"{' and '.join(map(str, paths))}: {format.name} is written as {wanted}.")
    usual_one = own.documents[0].syntax if own else next(iter(format.syntax.values()))
    endings = {path.suffix.lower() for path in paths} - {""}
    first, *others = {format.syntax.get(ending) for ending in endings} or {usual_one}
    if first is None or others:
        wanted = " or ".join(format.syntax)
        raise InputError(
            f"{paths[0]}: the ending contradicts what is to be written ({format.name}: {format.about}); give a name "
            f"ending in {wanted}, or another format with format= (--to of convert)."
        )
    return first


def _into(rig: StereoRig, format: Format, source: RigFile) -> tuple[str, ...]:
    """The texts of the source with what has changed."""
    before = rig_in(source.documents, format, source.unit, source.hints).turned(rig.turns)
    for old, new in ((before.left, rig.left), (before.right, rig.right)):
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
    unchanged = tuple(same_camera(*cameras) for cameras in ((before.left, rig.left), (before.right, rig.right)))
    texts = tuple(document.text for document in source.documents)
    if all(unchanged) and np.array_equal(before.extrinsics, rig.extrinsics):
        return texts
    target = Target(source.documents, not unchanged[0], not unchanged[1], source.hints)
    return _checked(rig, format, target, source.unit)


def _checked(rig: StereoRig, format: Format, target: Target, unit: str) -> tuple[str, ...]:
    old = target.documents
    asked, exchanged = chosen_cameras(format, old, target.hints)
    left, right = (target.right, target.left) if exchanged else (target.left, target.right)
    texts = format.texts(as_in_file(scaled(rig, 1.0 / METRES[unit]), exchanged), Target(old, left, right, asked))
    written = tuple(document(o.name, text, o.syntax) for o, text in zip(old, texts, strict=True))
    again = rig_in(written, format, unit, target.hints)
    if not same_rig(rig, again):
        raise InputError(
            f"the {format.name} file cannot take this rig without a loss; write it in another format, such as opencv."
        )
    return texts
