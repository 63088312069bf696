"""The health of a rig, read off its state."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal._json_data import json_data
from stereorecal.online._estimate import SIZE
from stereorecal.online._state import Offset, State
from stereorecal.recalibration import (
    DISTANCES,
    NORMAL_95,
    ROWS_APART,
    ROWS_MATTER,
    Condition,
    Interval,
    depth_error,
)

FAR = 30  # baselines
DEPTH_MATTERS = 5.0  # percent there
DEPTH_WRONG = 10.0  # percent there: what a calibration that is called healthy may hide
SURE = 1e-4  # chance of a change that is called significant
LATE = 4.0  # standard errors
LATE_MATTERS = 0.03  # frames


@dataclass(frozen=True, eq=False)
class Reading:
    """How the calibration in use stands to the true one, fused over all looks so far. Intervals are of 95 %.

    Attributes:
        axes: what would correct it: pitch, yaw, roll in degrees, y, z in percent of the baseline.
        row_error: of the last look, pixels at full size: the mean over tiles of a tile's median |row difference|.
        rows_px: root mean square of the rows that the correction would take away, pixels at full size.
        depth_percent: error of depth at 5, 10, 30 and 100 baselines.
        delay: of the right shutter, in frames.
        chance: of an offset as large as this one, or larger, if the calibration in use were right.
        chance_of_rotation: the same of pitch, yaw and roll alone.
        matters: whether it is more than 0.1 pixels of row, or 5 % of depth at 30 baselines.
        rotation_matters: whether pitch, yaw and roll alone would be.
    """

    axes: Mapping[str, Interval]
    row_error: float
    rows_px: Interval
    depth_percent: Mapping[int, Interval]
    delay: Interval
    chance: float
    chance_of_rotation: float
    matters: bool
    rotation_matters: bool

    @property
    def condition(self) -> Condition:
        """Repair, if the change is significant and matters. Healthy, if none that matters is in sight, no shutter is
        late, and the intervals stay within 0.3 pixels and 10 %. Cannot tell, otherwise."""
        if self.matters and self.chance < SURE:
            return Condition.REPAIR
        if not np.isfinite(self.chance):
            return Condition.CANNOT_TELL
        wide = self.rows_px.high > ROWS_APART or self.depth_percent[FAR].farthest > DEPTH_WRONG
        return Condition.CANNOT_TELL if self.matters or wide or self.late else Condition.HEALTHY

    @property
    def late(self) -> bool:
        """Whether a shutter is late: by 4 standard errors, and 0.03 frames."""
        half = (self.delay.high - self.delay.low) / 2.0
        return abs(self.delay.value) > max(LATE * half / NORMAL_95, LATE_MATTERS)

    @property
    def shifted(self) -> bool:
        """Whether it is to be repaired for y and z: its rotation alone does not matter, or is not significant. A bar
        that bends turns the cameras as well; a shutter that is late on a rig that travels straight on looks so."""
        turned = self.rotation_matters and self.chance_of_rotation < SURE
        return self.condition is Condition.REPAIR and not turned

    def as_dict(self) -> dict:
        """Plain data for JSON."""
        return json_data(
            {
                "condition": self.condition.name.lower(),
                "shifted": self.shifted,
                "axes": {name: _ends(axis) for name, axis in self.axes.items()},
                "row_error_px": self.row_error,
                "rows_px": _ends(self.rows_px),
                "depth_percent": {distance: _ends(error) for distance, error in self.depth_percent.items()},
                "delay_frames": _ends(self.delay),
            }
        )


def reading(state: State) -> Reading:
    """What a state says of the calibration in use."""
    from scipy.special import chdtrc  # a third of a second to import

    apart, covariance = state.estimate.offset - state.using, state.estimate.of_offset
    widths = NORMAL_95 * np.sqrt(np.diag(state.estimate.covariance))
    rows, near = _effect(state, apart)
    wide = NORMAL_95 * float(np.sqrt(max(np.trace(_steepness(state) @ covariance), 0.0)))
    nearer = NORMAL_95 * np.sqrt(np.maximum(np.sum(state.nearing @ covariance * state.nearing, axis=-1), 0.0))
    depths = np.stack([near, near + nearer, near - nearer], axis=-1).tolist()
    delay = state.estimate.delay
    return Reading(
        axes={
            name: Interval(value, value - width, value + width)
            for name, value, width in zip(state.chart.names, apart.tolist(), widths[:SIZE].tolist(), strict=True)
        },
        row_error=state.row_error,
        rows_px=Interval(rows, max(rows - wide, 0.0), rows + wide),
        depth_percent={at: Interval(*map(depth_error, three)) for at, three in zip(DISTANCES, depths, strict=True)},
        delay=Interval(delay, delay - float(widths[SIZE]), delay + float(widths[SIZE])),
        chance=float(chdtrc(SIZE, float(apart @ np.linalg.solve(covariance, apart)))),
        chance_of_rotation=float(chdtrc(3, float(apart[:3] @ np.linalg.solve(covariance[:3, :3], apart[:3])))),
        matters=_matters(rows, near),
        rotation_matters=_matters(*_effect(state, np.concatenate([apart[:3], np.zeros(SIZE - 3)]))),
    )


def _effect(state: State, apart: Offset) -> tuple[float, Float[np.ndarray, "4"]]:
    """Of an offset from the calibration in use: root mean square of rows, and the true depth over the one reported."""
    return float(np.sqrt(max(apart @ _steepness(state) @ apart, 0.0))), 1.0 + state.nearing @ apart


def _steepness(state: State) -> Float[np.ndarray, "5 5"]:
    return np.zeros((SIZE, SIZE)) if state.steepness is None else state.steepness


def _matters(rows: float, near: Float[np.ndarray, "4"]) -> bool:
    """Whether such an effect does."""
    return rows > ROWS_MATTER or abs(depth_error(float(near[DISTANCES.index(FAR)]))) > DEPTH_MATTERS


def _ends(found: Interval) -> dict[str, float]:
    return {"value": found.value, "low": found.low, "high": found.high}
