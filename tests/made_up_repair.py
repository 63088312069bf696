"""A made-up repair, with everything that its page can show, and names that try to break out."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereorecal.recalibration import DepthError, Interval
from stereorecal.report.repair_report import Change, Conclusion, RepairReport, Rows, Sight

EVIL = "<script>alert('x')</script>"


def sight(size: tuple[int, int], seed: int) -> Sight:
    rng = np.random.default_rng(seed)
    width, height = size
    left = rng.uniform(0, 255, (height, width))
    return Sight(
        left, np.roll(left, -3, axis=1), rng.uniform(0, 40, (height, width)), rng.random((height, width)) > 0.4
    )


def misfit(
    *, before: Mapping[int, float] | None = None, after: Mapping[int, float] | None = None, frames: int = 1, **changes
) -> dict[str, Any]:
    """A misfit of regions whose rows lie 0.02 px apart, but for those that are given by place, in the first frame."""
    places = [*range(48)] * frames
    apart = {
        when: [{**dict.fromkeys(range(48), 0.02), **(given if index < 48 else {})}[p] for index, p in enumerate(places)]
        for when, given in (("before", before or {}), ("after", after or {}))
    }
    frame = [index // 48 for index in range(48 * frames)]
    return {"frame": frame, "place": places, **apart, "error": [0.01] * len(places), **changes}


def depth_error(metres: float, low: float, high: float) -> DepthError:
    return DepthError(metres, Interval(low, low, high))


def made_up(
    size: tuple[int, int] = (320, 240),
    conclusion: Conclusion = Conclusion.REPAIRED,
    *,
    measured: bool = True,
    **changes,
) -> RepairReport:
    """A report; without rows, misfit and expectations unless `measured`."""
    rng = np.random.default_rng(0)
    field = rng.normal(0.0, 0.1, (18, 24))
    field[3, 4] = np.nan
    accepted, healthy = conclusion is Conclusion.REPAIRED, conclusion in (Conclusion.REPAIRED, Conclusion.GOOD)
    parts = {
        "name": f"harbour {EVIL}",
        "conclusion": conclusion,
        "verdict": "Repaired: epipolar error 8.92 -> 0.10 px; depth corrected."
        if accepted
        else "Not repaired: misfit.",
        "advice": "Use the new calibration." if accepted else "Take one more pair.",
        "text": "Repaired or not.\nmatched  34 % of 100 pixels",
        "search": "the strategy met its own stopping rule",
        "baseline": 0.356,
        "facts": {"epipolar error of the matches": ("8.92 px", "0.10 px")},
        "frame": f"0001.png {EVIL}",
        "before": sight(size, 1),
        "after": sight(size, 2),
        "rows": Rows(9.0 + field, field, rng.normal(9, 1, 500), rng.normal(0, 0.2, 500)) if measured else None,
        "misfit": misfit(after={0: 0.9, 1: 0.9, 8: 0.9}) if measured else None,
        "expected": np.abs(field[:13, :17]) if measured and healthy else None,
        "expected_said": "epipolar error 0.07 px where the images show something; depth -14 to +17 cm at 3.6 m"
        if measured and healthy
        else None,
        "axes": [Change("pitch", "°", 0.1, 0.8, 0.002, True), Change("z", "mm", 1.0, 1.0, None, False)],
        "intrinsics": [("left", Change("focal length", "px", 500.0, 1.25, 0.75, True, 2))],
        "depths": [
            (depth_error(1.8, -8.1, -7.2), depth_error(1.8, -1.0, 1.2)),
            (depth_error(35.6, 3.0, float("inf")), depth_error(35.6, -9.0, 240.0)),
        ]
        if healthy
        else [],
        "frames": [("0001.png", "used", ""), ("0002.png", "left out", "it shows another rig than the others")],
        "remarks": ["Not determined by these images: y with z."],
        "command": f"python -m stereorecal recalibrate '{EVIL} a b'",
        "settings": {"seed": 7, "matcher": {"block_size": 9}, "stages": ["a", "b"], "ranges": EVIL},
        "calibrations": {"before": '{"T": [1.0, 0.0, 0.0]}', "after": '{"T": [1.0, 0.0, 0.1]}'},
    }
    return RepairReport(**{**parts, **changes})
