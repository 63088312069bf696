"""The calibration that `recalibrate` gives back: where it goes, in which form, and what it may replace."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stereorecal._errors import InputError
from stereorecal.cli._options import value_of
from stereorecal.cli._places import CalibrationPath, Place, check_places, paths, refuse_replacing_inputs
from stereorecal.cli._recordings import rig_of
from stereorecal.cli._repair_commands import RecalibrateOptions
from stereorecal.geometry import StereoRig, changed_camera
from stereorecal.io import back_up, calibration_files, check_savable, next_copy, prior_beside, save_rig, unsaid_unit
from stereorecal.objectives import Parameters
from stereorecal.recalibration import Settings, Solution, what_may_change
from stereorecal.recordings import Scene


@dataclass(frozen=True)
class Output:
    """What is written once a candidate was accepted.

    Attributes:
        place: the file of the calibration, or those of the left and the right camera; None: nowhere.
        replaced: whether it is the calibration that the repair started from, of which a copy is kept.
        prior_path: the file for what is known of it, where its format has no place for that.
        note: what to add of its unit once it is written.
    """

    place: CalibrationPath | None = None
    replaced: bool = False
    prior_path: Path | None = None
    note: str = ""

    @property
    def files(self) -> list[Path]:
        """The files of the calibration."""
        return [] if self.place is None else paths(self.place)


def output_of(options: RecalibrateOptions, rig: StereoRig, free: Sequence[str], read: Iterable[Path]) -> Output:
    """Where the repaired calibration of a rig goes; all that can be said before the work is said here. Of the files
    that were read none is replaced, but for the calibration by itself."""
    place = value_of(options, "output")
    files = [] if place is None else paths(place)
    calibrations = [path.resolve() for path in calibration_files(rig)]
    replaced = bool(files) and [path.resolve() for path in files] == calibrations
    others = [one for one in options.places if not (replaced and one.path in files)]
    refuse_replacing_inputs(others, {*read, *options.image_inputs, *calibrations})
    if place is None:
        return Output()
    if replaced:
        check_savable(rig, place, format=rig.source.format)  # which may be read only
    check_savable(_probe_rig(rig, free), place)
    prior_path = prior_beside(rig, place)
    more = [Place("--output, which keeps a copy,", next_copy(path)) for path in files if replaced]
    more += [] if prior_path is None else [Place("--output", prior_path)]
    check_places([*more, *options.places], force=options.force)
    unit = unsaid_unit(rig, place)
    return Output(place, replaced, prior_path, f" (translation in {unit})" if unit else "")


def what_it_holds(output: Output, rig: StereoRig, settings: Settings) -> Parameters:
    """What may change, of what is free: where that is everything, by name as far as the output format can hold it."""
    free = settings.free
    if output.place is None or not free.everything:
        return free
    intrinsics = what_may_change(rig, settings).intrinsics
    if not intrinsics:
        return free
    held = list(free.names)
    for name in intrinsics:
        try:
            check_savable(_probe_rig(rig, [name]), output.place)
        except InputError:
            continue
        held.append(name)
    return replace(free, free=tuple(held), everything=False)


def save(solution: Solution, output: Output, scene: Scene, options: RecalibrateOptions) -> list[Path]:
    """Write the calibration and what is known of it; one that is replaced is kept beside it: where."""
    assert output.place is not None
    backups = [back_up(path) for path in output.files] if output.replaced else []
    if output.replaced and output.prior_path is not None and output.prior_path.exists():
        back_up(output.prior_path)
    rig = replace(solution.rig, source=rig_of(scene).source)
    save_rig(rig, output.place, scene.info, options.force, prior=solution.prior)
    return backups


def _probe_rig(rig: StereoRig, free: Sequence[str]) -> StereoRig:
    """A rig as a repair could leave it, to find out what a format holds."""
    small = 1e-4
    shift = small * float(rig.baseline) * np.array([0.0, 1.0, -1.0])
    moved = rig.with_extrinsics(rig.extrinsics + np.array([small, -small, small, *shift]))
    cameras = {}
    for side in ("left", "right"):
        names = [name.partition(".")[2] for name in free if name.startswith(f"{side}.")]
        cameras[side] = changed_camera(getattr(rig, side), dict.fromkeys(names, small))
    return replace(moved, **cameras)
