"""What became of intrinsics that were refined, camera by camera, in units of a calibration file."""

from typing import Any

from stereorecal.geometry import intrinsic
from stereorecal.report.repair_report import Lens

_CALLED = {"f": "focal length, f", "cx": "centre, cx", "cy": "centre, cy", "aspect": "aspect, fy / fx"}


def lenses_of(solution: Any) -> list[Lens]:
    """One row for each number, if they were taken; else none: then they stay, and are no answer."""
    seen = solution.intrinsics
    if seen is None or not seen.taken:
        return []
    found = []
    for full, wide in zip(seen.names, seen.interval.tolist(), strict=True):
        camera, _, name = full.partition(".")
        if not name:
            continue  # the baseline, which is an axis of the rig
        before, after = (intrinsic(getattr(rig, camera), name) for rig in (solution.initial, solution.candidate))
        half_width = wide / 100.0 * after if name in ("f", "aspect") else wide
        pixels = name in ("f", "cx", "cy")
        unit, digits = ("px", 2) if pixels else ("", 5)
        observed = full not in seen.undetermined
        found.append(Lens(camera, _CALLED.get(name, name), unit, digits, before, after, half_width, observed))
    return found
