"""A scene from its parts: image pairs and a calibration that fits them."""

from collections.abc import Callable, Sequence
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io._about import about
from stereorecal.io._paths import AnyPath
from stereorecal.io.formats._calib_json import Calibration, load_calibration
from stereorecal.io.formats._units import warn_of_units
from stereorecal.io.images._pairs import load_pairs
from stereorecal.recordings import Pair, Scene, check_pairs


def gather_scene(left: AnyPath, right: AnyPath, calibration: AnyPath, limit: int | None = None) -> Scene:
    """The scene of files in any places: images as `load_pairs` finds them, and a calibration like a scene folder's
    calib.json. The scene is named after `left`.

    Args:
        limit: read only the first `limit` pairs.

    Raises:
        InputError, UnsupportedModelError: as `load_pairs` and `load_scene`.

    Warns:
        CalibrationWarning: as `load_rig`.
    """
    return calibrated_scene(str(left), lambda: load_pairs(left, right, limit), calibration)


def calibrated_scene(name: str, pairs: Callable[[], Sequence[Pair]], calibration: AnyPath) -> Scene:
    """The scene of pairs, which are read once the calibration is, and errors and warnings as `gather_scene`."""
    found = load_calibration(Path(calibration))
    read = pairs()
    with about(calibration):
        scene = scene_of(name, found, read)
    warn_of_units(calibration, scene.rig)
    return scene


def scene_of(name: str, calibration: Calibration, pairs: Sequence[Pair]) -> Scene:
    """The scene of a calibration and pairs.

    Raises:
        InputError: if there is no pair, or an image has another size than the calibration says.
    """
    rig, (width, height) = calibration.rig, calibration.size
    if rig is not None:
        check_pairs(rig, list(pairs))
    elif any(pair.size != (width, height) for pair in pairs):
        raise InputError(f"an image is not {width}x{height} as the calibration says; correct one of them.")
    return Scene(name, rig, tuple(pairs), calibration.reference, calibration.info)
