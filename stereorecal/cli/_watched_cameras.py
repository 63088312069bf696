"""Cameras to be watched while they run."""

from collections.abc import Iterable, Sequence
from itertools import chain, islice

from stereorecal._errors import InputError
from stereorecal.cli import _option_values
from stereorecal.cli._calibration_paths import calibration_path
from stereorecal.cli._repair_commands import MonitorOptions
from stereorecal.io import calibrated_scene, camera_pairs
from stereorecal.recordings import Images, Pair, Scene

_DARK = 100  # pairs that cannot be used, at most, before the first that can: a camera that is switched on
_OTHERS = ("left", "right", "side_by_side", "bag", "limit")


def watched_cameras(cameras: Sequence[str], options: MonitorOptions) -> tuple[Scene, Iterable[Pair | Images]]:
    """A scene of the calibration and the first pair of the cameras; and all their pairs, as they come.

    Raises:
        InputError: if a recording is named, too, there is no calibration, or a camera cannot be used.
    """
    if options.scenes or any(getattr(options, name) is not None for name in _OTHERS):
        raise InputError("--camera takes the place of a recording, and of --limit; leave the others out.")
    if options.calibration is None:
        raise InputError("--camera needs --calibration, the file of the rig.")
    if options.tolerance is not None and not options.tolerance >= 0.0:
        raise InputError(f"--tolerance is {options.tolerance}; give seconds, such as 0.005.")
    names = camera_names(cameras)
    wanted = options.stretch()
    coming = camera_pairs(names, options.tolerance)
    before: list[Pair | Images] = []

    def first(_: object) -> tuple[Pair, ...]:
        for pair in islice(coming, _DARK):
            before.append(pair)
            if isinstance(pair, Pair):
                return (pair,)
        raise InputError(f"camera {' and '.join(names)}: of {len(before)} pairs none can be used; check the cameras.")

    calibration = calibration_path(options.calibration, "--calibration")
    how = {"format": options.format, "unit": options.unit}
    chosen = _option_values.camera_pair(options.cameras)
    scene = calibrated_scene(f"camera {' and '.join(names)}", first, calibration, **how, cameras=chosen)
    if scene.rig is None:
        raise InputError("--calibration: the file holds no calibration; give another.")
    return scene, islice(chain(before, coming), wanted.start, wanted.stop, wanted.step)


def camera_names(words: Sequence[str]) -> list[str]:
    """One name, or two: two words, or one with a comma in it, which a pipeline may have as well.

    Raises:
        InputError: if there are more.
    """
    names = words[0].split(",") if len(words) == 1 and "!" not in words[0] else list(words)
    if len(names) > 2 or not all(names):
        raise InputError(f"--camera is {' '.join(words)!r}; give one name, or two, such as 0,1.")
    return names
