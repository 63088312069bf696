"""How the rig stands and what the node lacks, as plain data for `/diagnostics`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stereorecal.online import FAR, Reading
from stereorecal.recalibration import Condition
from stereorecal_ros._log import Level


@dataclass(frozen=True)
class Status:
    """One status.

    Attributes:
        level: OK: healthy. WARN: it cannot be told, or a calibration waits to be applied. ERROR: the calibration that
            is published is to be repaired, or nobody watches. STALE: an input is missing.
        message: one line.
        values: by name.
    """

    level: Level
    message: str
    values: Mapping[str, str] = field(default_factory=dict)


def status_of(
    found: Reading | None,
    *,
    missing: Sequence[str] = (),
    waits: bool = False,
    dead: str | None = None,
    unsaved: str | None = None,
    age: float | None = None,
    counts: Mapping[str, int | bool] | None = None,
) -> Status:
    """What to say.

    Args:
        found: of the calibration that is published; None before there is one.
        missing: inputs that are silent, and what they lack.
        waits: whether an accepted calibration waits to be applied.
        dead: why nobody watches, if nobody does.
        unsaved: why nothing is kept over a restart, if nothing is.
        age: seconds since the last pair that told something.
        counts: whatever else was counted.
    """
    values = {} if found is None else _numbers(found)
    values["missing"] = ", ".join(missing) or "nothing"
    values["age of the verdict [s]"] = "none yet" if age is None else f"{age:.1f}"
    values["accepted calibration waits for apply"] = str(waits)
    values.update({name: str(value) for name, value in (counts or {}).items()})
    level, message = _said(found, missing, dead)
    if waits:
        level, message = max(level, Level.WARN), f"{message}; an accepted calibration waits for ~/apply"
    if unsaved is not None:
        level, message = max(level, Level.WARN), f"{message}; nothing is kept over a restart: {unsaved}"
    return Status(level, message, values)


def _said(found: Reading | None, missing: Sequence[str], dead: str | None) -> tuple[Level, str]:
    if dead is not None:
        return Level.ERROR, dead
    if found is not None and found.condition is Condition.REPAIR:
        return Level.ERROR, found.condition.value
    if missing:
        return Level.STALE, f"missing: {', '.join(missing)}"
    if found is None:
        return Level.STALE, "no pair has been evaluated yet"
    return (Level.OK if found.condition is Condition.HEALTHY else Level.WARN), found.condition.value


def _numbers(found: Reading) -> dict[str, str]:
    """With their 95 % intervals."""
    rows, depth, delay = found.rows_px, found.depth_percent[FAR], found.delay
    told = {
        "condition": found.condition.name.lower(),
        "epipolar error of the last pair [px]": f"{found.row_error:.3f}" if np.isfinite(found.row_error) else "unknown",
        "epipolar error over the view [px]": f"{rows.value:.3f} ({rows.low:.3f} to {rows.high:.3f})",
        f"depth error at {FAR} baselines [%]": f"{depth.value:+.1f} ({depth.low:+.1f} to {depth.high:+.1f})",
        "delay of the right shutter [pairs]": f"{delay.value:+.3f} ({delay.low:+.3f} to {delay.high:+.3f})",
    }
    for name, axis in found.axes.items():
        unit = "% of the baseline" if name in "yz" else "deg"
        told[f"{name} to correct [{unit}]"] = f"{axis.value:+.3f} ({axis.low:+.3f} to {axis.high:+.3f})"
    return told
