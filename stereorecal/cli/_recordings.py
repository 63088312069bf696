"""The recordings that a command is about: scene folders, or files that lie anywhere."""

import argparse
from dataclasses import replace
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.cli import _calibrations, _values
from stereorecal.io import gather_scene, load_scene
from stereorecal.recordings import Scene


def recordings(options: argparse.Namespace) -> list[Scene]:
    """The scenes that were asked for, each with a rig.

    Raises:
        InputError: if none or both kinds were asked for, or one cannot be used.
    """
    loose = (options.left, options.right, options.calibration)
    if bool(options.scenes) == any(loose) or (any(loose) and not all(loose)):
        raise InputError("give scene folders, or --left, --right and --calibration together.")
    if options.scenes and (options.format or options.unit):
        raise InputError("--format and --unit belong to --calibration; leave them out.")
    limit = _values.frame_limit(options.frames)
    if options.scenes:
        found = [load_scene(Path(path), limit=limit) for path in options.scenes]
    else:
        calibration = _calibrations.place(options.calibration, "--calibration")
        reading = {"format": options.format, "unit": options.unit}
        found = [gather_scene(options.left, options.right, calibration, limit, **reading)]
    for scene in found:
        if scene.rig is None:
            raise InputError(f"{scene.name}: the scene has no calibration; give one to start from.")
    if len({scene.name for scene in found}) < len(found):
        return [replace(scene, name=path) for scene, path in zip(found, options.scenes, strict=True)]
    return found
