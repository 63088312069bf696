"""From files to a rig, and which two cameras of a file are the left and the right one."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np

from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import AS_IN_FILE, METRES, StereoRig, checked_unit, euler_from_rotation, inferred_unit
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Format, Hints
from stereorecal.io.formats._format_list import half_of, named, recognised, unknown
from stereorecal.io.formats._numbers import trimmed
from stereorecal.io.formats._rig_file import ENDING, RigFile, read_stored_prior
from stereorecal.io.formats.text._document import Document, Syntax, read_document
from stereorecal.io.formats.text._yaml import DOCUMENTS, SEVERAL

_SIDES = ("left", "right")  # names of the first two cameras in every format
_NUMBERS = ("0", "1")  # and in those that name none


def chosen_cameras(format: Format, documents: Documents, hints: Hints) -> tuple[Hints, bool]:
    """What a format is to read, and whether the second one of its two cameras is the left one."""
    names = tuple(format.cameras(documents)) if format.cameras else _NUMBERS
    given = hints.cameras
    for first, second in (_SIDES, names[:2] if len(names) > 1 else _NUMBERS):
        if given in (None, (first, second), (second, first)):
            return replace(hints, cameras=None), given == (second, first)
    if format.cameras is None:
        raise InputError(
            f"the cameras are {_listed(given)}, and {format.name} names none; give right,left if the second one of the "
            "file is the left one, or leave it out."
        )
    if len(set(given)) < 2 or not set(given) <= set(names):
        raise InputError(
            f"the cameras are {_listed(given)}, and the file has {_listed(names)}; give the left and the right one."
        )
    return hints, False


def checked_cameras(given: object) -> tuple[str, str] | None:
    """The names of the left and the right camera, as they were given."""
    if given is None:
        return None
    if not isinstance(given, tuple | list) or len(given) != 2 or not all(isinstance(name, str) for name in given):
        raise InputError(
            f'cameras is {given!r}; give the names of the left and the right camera, such as ("cam1", "cam0"), or '
            '("right", "left") to exchange them.'
        )
    return given[0], given[1]


def left_first(rig: StereoRig, exchanged: bool, hints: Hints, files: int) -> StereoRig:
    """A rig as its file has it, with the left camera first.

    Args:
        exchanged: whether the second one of the file is the left one.
        hints, files: with which it was read, and how many files it takes, for the message.
    """
    rig = _exchanged(rig) if exchanged else rig
    x, y, z = np.asarray(rig.side_by_side().translation)
    if x >= max(abs(y), abs(z)):
        raise InputError(
            f"left and right are swapped: T[0] must be negative (x_right = R x_left + T); {_way(hints, files)}"
        )
    return replace(rig, source=None)


def as_in_file(rig: StereoRig, exchanged: bool) -> StereoRig:
    """The inverse of `left_first`, of images as they were taken."""
    rig = rig.as_taken()
    return _exchanged(replace(rig, source=AS_IN_FILE)) if exchanged else rig


def _way(hints: Hints, files: int) -> str:
    if hints.cameras is not None:
        return f"the cameras were given as {_listed(hints.cameras)}: give {_listed(hints.cameras[::-1])}."
    if files == 2:
        return (
            "give the left camera's file first, or, if it was, correct the sign of the translation (P[0, 3] in ROS's "
            "files)."
        )
    return (
        'if the first camera of the file is the right one, give cameras=("right", "left"), on the command line '
        "--cameras right,left; if both are upside down, turn images and calibration by 180 degrees."
    )


def _exchanged(rig: StereoRig) -> StereoRig:
    back = np.asarray(rig.rotation).T
    extrinsics = np.concatenate([euler_from_rotation(back), -back @ np.asarray(rig.translation)])
    return replace(rig, left=rig.right, right=rig.left, extrinsics=extrinsics)


def _listed(names: Sequence[str]) -> str:
    return ",".join(names) if names else "no camera"


_ENDINGS = (".yaml", ".yml", ".xml", ".json", ".txt")
_BINARY = (".npz", ".npy", ".mat")  # read where a folder has no texts: most are images and maps
_OF_CAMERAS = ("cam0/sensor.yaml", "cam1/sensor.yaml")  # EuRoC's, which lie in folders of their own
_MOST = 12  # files of a folder that are tried in pairs
_MOST_TOGETHER = 40
_SCENE = "calib.json"
_STATED = {"matlab": "WorldUnits", "stereorecal": "baseline_m"}  # keys of files that state their unit


def read_files(
    paths: Sequence[Path],
    format: str | None = None,
    unit: str | None = None,
    hints: Hints | None = None,
    if_missing: str = "check the path.",
) -> StereoRig:
    """The rig in one file, in a left and a right file, or in a folder that holds such; it remembers where it came from.

    Args:
        format: name of the format; default: recognised.
        unit: of lengths in the files; default: that of the format, or inferred from the length of the baseline.
        if_missing: the end of the message if a file does not exist.

    Raises:
        InputError: naming the file, if it cannot be read, no format is recognised, or it holds no valid calibration.
        UnsupportedModelError: if the model of a lens is not known.
    """
    checked_unit(unit)
    hints = hints or Hints()
    documents, found = _documents_of(paths, format, hints, if_missing)
    rig = rig_in(documents, found, unit, hints)
    return replace(rig, source=replace(rig.source, beside=read_stored_prior(Path(documents[0].name))))


def has_own_unit(paths: Sequence[Path], format: str | None = None) -> bool:
    """Whether the format of files has a unit of lengths.

    Raises:
        InputError: as `read_files`, if the format is not recognised.
    """
    return _documents_of(paths, format, Hints(), "check the path.")[1].unit is not None


def _documents_of(paths: Sequence[Path], format: str | None, hints: Hints, if_missing: str) -> tuple[Documents, Format]:
    chosen = None if format is None else named(format)
    if len(paths) == 1 and paths[0].is_dir() and paths[0].suffix.lower() not in _ENDINGS:
        documents = _in_folder(paths[0], chosen, hints)
    else:
        documents = tuple(_parsed_file(path, chosen, if_missing) for path in paths)
    return documents, chosen or _recognised(documents)


def rig_in(documents: Documents, format: Format, unit: str | None, hints: Hints) -> StereoRig:
    """The rig described by the files of a format; lengths in metres."""
    names = " and ".join(document.name for document in documents)
    if len(documents) < format.files:
        raise InputError(f"{names}: {format.name} has a file for each camera; give the left and the right one.")
    with about(names) if len(documents) == 1 or format.files == 1 else nullcontext():
        try:
            asked, exchanged = chosen_cameras(format, documents, hints)
            rig = format.read(documents, asked)
        except (AttributeError, IndexError, KeyError, TypeError):  # a list where there should be keys, and the like
            raise InputError(
                f"{documents[0].name}: not arranged as {format.name} is ({format.about}); check the file or the format."
            ) from None
    with about(names):
        rig = left_first(rig, exchanged, hints, format.files)
    rig = at_common_size(rig) if hints.common_size else rig
    with about(names):
        stated = _unit_in(format, unit)
    used = stated or inferred_unit(float(rig.baseline))
    left, right = (
        replace(camera, distortion=trimmed(np.asarray(camera.distortion))) for camera in (rig.left, rig.right)
    )
    rig = replace(rig, left=left, right=right)
    source = RigFile(format.name, documents, hints, used, inferred=stated is None)
    return replace(scaled(rig, METRES[used]), source=source)


def _unit_in(format: Format, given: str | None) -> str | None:
    """The unit of lengths in files: the given one, else that of the format; None if neither tells.

    A format's unit is what its programs expect, and ROS, Kalibr and others write whatever the board was measured in."""
    if format.name in _STATED and given not in (None, format.unit):
        raise InputError(
            f"lengths of a {format.name} file are in the unit that it states ({_STATED[format.name]}), not in {given}; "
            "leave the unit out, or correct the file."
        )
    return given or format.unit


def scaled(rig: StereoRig, factor: float) -> StereoRig:
    """The rig with T times a factor."""
    factors = np.array([1.0, 1.0, 1.0, factor, factor, factor])
    return rig if factor == 1.0 else rig.with_extrinsics(rig.extrinsics * factors)


def at_common_size(rig: StereoRig) -> StereoRig:
    """The rig whose larger images are resampled to the size of the smaller ones."""
    if rig.left.size == rig.right.size:
        return rig
    return rig.resized(min(rig.left.size, rig.right.size, key=lambda size: size[0] * size[1]))


def _parsed_file(path: Path, format: Format | None, if_missing: str = "check the path.") -> Document:
    """A file, parsed as the format that was chosen is: as lines, where it has those, over which others stumble."""
    kinds = () if format is None else format.syntax.values()
    of_lines = next((kind for kind in kinds if kind in (Syntax.COLONS, Syntax.EQUALS)), None)
    return read_document(path, of_lines, if_missing, lines=format is None or of_lines is not None)


def _recognised(documents: Documents) -> Format:
    found = recognised(documents)
    if found is not None:
        return found
    names = " and ".join(document.name for document in documents)
    half = half_of(documents)
    if half is not None:
        raise InputError(
            f"{names}: this is one of two files ({half.name}: {half.about}); give both, left before right."
        )
    if any(document.content.keys() == {DOCUMENTS} for document in documents):
        raise InputError(f"{names}: {SEVERAL}")
    if len(documents) == 2:
        return _likely(documents, names)
    raise InputError(f"{names}: {unknown(documents)}")


def _likely(documents: Documents, names: str) -> Format:
    """The format of two files that none can read together: that of one of them, whose reader says what the other one
    lacks."""
    looks = [recognised((document,)) or half_of((document,)) for document in documents]
    found = [format for format in looks if format is not None]
    if not found:
        raise InputError(f"{names}: {unknown(documents)}")
    if len(found) == 2 and found[0] is found[1]:
        raise InputError(f"{names}: each is a calibration by itself ({found[0].name}); give one.")
    if len(found) == 2 or found[0].files == 1:
        one, other = ("nothing that is known" if format is None else format.name for format in looks)
        raise InputError(
            f"these two do not belong together: {documents[0].name} looks like {one}, {documents[1].name} like "
            f"{other}; give two of one kind, or the whole one alone."
        )
    return found[0]


def _in_folder(folder: Path, format: Format | None, hints: Hints) -> Documents:
    """The file of a folder that holds a calibration, or the two that do so together; if none does, the likely ones."""
    if format is None and (folder / _SCENE).is_file():
        return (read_document(folder / _SCENE),)
    found = _documents_in(folder, format)
    fitting = [format] if format is not None else None
    single = [(document,) for document in found if _whole((document,), fitting, hints)]
    parts = [document for document in found if (document,) not in single][:_MOST]
    pairs = {
        frozenset(document.name for document in pair): pair
        for pair in reversed(list(permutations(parts, 2)))
        if _whole(pair, fitting, hints)
    }
    whole = [*single, *reversed(pairs.values())]
    if not whole and 2 < len(found) <= _MOST_TOGETHER and _whole(found, fitting, hints):  # a file for each matrix
        return found
    if len(whole) == 1:
        return whole[0]
    if whole:
        names = (" with ".join(str(Path(each.name).relative_to(folder)) for each in documents) for documents in whole)
        raise InputError(f"{folder}: several calibrations are in there ({', '.join(names)}); give one of them.")
    if not found:
        raise InputError(
            f"{folder}: there is no calibration file in it that can be read; give a file, or another folder."
        )
    for documents in (*permutations(parts, 2), *((document,) for document in found)):
        fits = recognised(documents) if format is None else format
        if fits is not None and fits.can_read(documents):
            return documents  # whose reader says what is wrong with it
    if format is None and len(found) <= 2:
        return found
    raise InputError(f"{folder}: {unknown(found)}")


def looks_calibrated(folder: Path) -> bool:
    """Whether there is a file in a folder whose name may be that of a calibration; opens none."""
    return bool(_files_in(folder))


def _files_in(folder: Path, endings: tuple[str, ...] = _ENDINGS) -> list[Path]:
    found = (path for path in folder.iterdir() if path.suffix.lower() in endings and path.is_file())
    return sorted(path for path in found if not path.name.endswith(ENDING))


def _documents_in(folder: Path, format: Format | None) -> Documents:
    paths = _files_in(folder) or _files_in(folder, _BINARY)
    cameras = (root / name for root in (folder, folder / "mav0") for name in _OF_CAMERAS)
    documents = []
    for path in (*paths, *(path for path in cameras if path.is_file())):
        try:
            documents.append(_parsed_file(path, format))
        except InputError:
            continue  # something else that lies there
    return tuple(document for document in documents if document.content)


def _whole(documents: Documents, fitting: list[Format] | None, hints: Hints) -> bool:
    """Whether documents are a whole calibration, and not a part of one."""
    format = recognised(documents) if fitting is None else fitting[0]
    if format is None or not format.can_read(documents) or len(documents) < format.files:
        return False
    try:
        rig_in(documents, format, None, hints)
    except UnsupportedModelError:
        return len(documents) == format.files or half_of(documents) is None
    except InputError:
        # One that has an error of its own is to be read, so that it is named; half a calibration is not.
        return len(documents) == 1 and half_of(documents) is None and format.name != "opencv"
    return True
