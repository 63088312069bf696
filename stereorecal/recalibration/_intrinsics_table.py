"""What became of intrinsics that were refined, camera by camera, in units of a calibration file."""

from stereorecal.geometry import StereoRig, intrinsic
from stereorecal.recalibration._freed_intrinsics import Intrinsics
from stereorecal.report.repair_report import Intrinsic

_CALLED = {"f": "focal length, f", "cx": "centre, cx", "cy": "centre, cy", "aspect": "aspect, fy / fx"}


def intrinsics_table(intrinsics: Intrinsics | None, initial: StereoRig, candidate: StereoRig) -> list[Intrinsic]:
    """One row for each number, if they were taken; else none: then they stay, and are no answer."""
    if intrinsics is None or not intrinsics.taken:
        return []
    found = []
    for full, wide in zip(intrinsics.names, intrinsics.interval.tolist(), strict=True):
        camera, _, name = full.partition(".")
        if not name:
            continue  # the baseline, which is an axis of the rig
        before, after = (intrinsic(getattr(rig, camera), name) for rig in (initial, candidate))
        half_width = wide / 100.0 * after if name in ("f", "aspect") else wide
        pixels = name in ("f", "cx", "cy")
        unit, digits = ("px", 2) if pixels else ("", 5)
        observed = full not in intrinsics.undetermined
        found.append(Intrinsic(camera, _CALLED.get(name, name), unit, digits, before, after, half_width, observed))
    return found
