"""A scene from its parts: image pairs and a calibration that fits them."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io._read_files import AnyPath, about
from stereorecal.io.formats._file_units import warn_of_units
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._scene_calibration import Calibration, load_calibration
from stereorecal.io.images._load_pairs import load_pairs
from stereorecal.recordings import LazyPairs, Pair, Scene, check_pairs


def gather_scene(
    left: AnyPath,
    right: AnyPath,
    calibration: AnyPath | tuple[AnyPath, AnyPath],
    limit: int | None = None,
    *,
    format: str | None = None,
    unit: str | None = None,
) -> Scene:
    """The scene of files in any places: images as `load_pairs` finds them, and a calibration in any format that
    `load_rig` reads. The scene is named after `left`. A calibration without image size is for images of this size.

    Args:
        calibration: a file, a folder that holds one, or the left and the right camera's file.
        limit: read only the first `limit` pairs.
        format, unit: as of `load_rig`.

    Raises:
        InputError, UnsupportedModelError: as `load_pairs` and `load_rig`.

    Warns:
        CalibrationWarning: as `load_rig`.
    """
    return calibrated_scene(str(left), lambda: load_pairs(left, right, limit), calibration, format=format, unit=unit)


def calibrated_scene(
    name: str,
    pairs: Callable[[], Sequence[Pair]],
    calibration: AnyPath | tuple[AnyPath, AnyPath],
    *,
    format: str | None = None,
    unit: str | None = None,
) -> Scene:
    """The scene of pairs, which are read once it is sure that there is a file of a calibration; else as
    `gather_scene`."""
    paths = tuple(map(Path, calibration)) if isinstance(calibration, tuple) else (Path(calibration),)
    for path in paths:
        if not path.exists():
            raise InputError(f"{path}: there is no such file; check the path.")
    read = pairs()
    found = load_calibration(paths, format, unit, Hints(size=read[0].size if read else None))
    where = " and ".join(map(str, paths))
    with about(where):
        scene = scene_of(name, found, read)
    warn_of_units(where, scene.rig)
    return scene


def scene_of(name: str, calibration: Calibration, pairs: Sequence[Pair]) -> Scene:
    """The scene of a calibration and pairs.

    Raises:
        InputError: if there is no pair, or an image has another size than the calibration says.
    """
    pairs = tuple(pairs)
    if calibration.rig is not None and not pairs:
        check_pairs(calibration.rig, pairs)  # says that there is none
    for pair in pairs:
        _check(calibration, pair)
    return Scene(name, calibration.rig, pairs, calibration.reference, calibration.info)


def fitting(where: Path, calibration: Calibration, pairs: LazyPairs) -> LazyPairs:
    """The pairs, each checked when it is read: InputError about `where` if it does not fit the calibration."""
    return pairs.checked(partial(_check_about, where, calibration))


def _check_about(where: Path, calibration: Calibration, pair: Pair) -> None:
    with about(where):
        _check(calibration, pair)


def _check(calibration: Calibration, pair: Pair) -> None:
    width, height = calibration.size
    if calibration.rig is not None:
        check_pairs(calibration.rig, pair)
    elif pair.size != (width, height):
        raise InputError(f"an image is not {width}x{height} as the calibration says; correct one of them.")
