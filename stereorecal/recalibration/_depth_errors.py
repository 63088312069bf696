"""Errors of depth at the distances that a user asks for, or that the images show."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import json_data
from stereorecal._errors import InputError
from stereorecal.estimation import DISTANCES, Estimate, points_shown
from stereorecal.recalibration._expected import Interval
from stereorecal.report.number_text import METRES, between, distance

_SHARES = (0.1, 0.5, 0.9)  # of what the images show: near, in the middle, far
_BASELINES = (5.0, 10.0, 30.0)  # where they show nothing

Distance = tuple[float, str]  # and its unit: mm, cm, m, or B for baselines


@dataclass(frozen=True)
class DepthError:
    """The error of depth at a distance, on average over the view.

    Attributes:
        distance: metres.
        percent: of the distance; positive: too far; infinite where a point seems to lie at infinity or beyond.
    """

    distance: float
    percent: Interval

    @property
    def metres(self) -> Interval:
        """The same in metres."""
        per_percent = 0.01 * self.distance
        return Interval(
            per_percent * self.percent.value, per_percent * self.percent.low, per_percent * self.percent.high
        )

    @property
    def significant(self) -> bool:
        """Whether its interval leaves out 0."""
        return self.percent.low > 0.0 or self.percent.high < 0.0

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return json_data({"percent": self.percent.as_dict(), "metres": self.metres.as_dict()})

    @property
    def where(self) -> str:
        """Its distance, such as "2.5 m"."""
        return distance(self.distance)

    def __str__(self) -> str:
        return between(self.metres.low, self.metres.high)


def reported_depths(
    estimated: Estimate, used: Float[np.ndarray, "n"], distances: Sequence[Distance], best: Float[np.ndarray, "n"]
) -> tuple[DepthError, ...]:
    """The errors of depth of the rig at θ = used.

    Args:
        distances: at which; none: near, middle and far of what the images show, to one digit.
        best: θ of the rig that tells how far away that is: at the posterior's mean depth may be anything.
    """
    baseline = float(estimated.chart.rig.baseline)
    named = dict.fromkeys(value * METRES.get(unit, baseline) for value, unit in distances)  # 2m and 200cm are one
    metres = list(named) or _shown(estimated, best)
    found = estimated.depth_error_percent(used, tuple(one / baseline for one in metres))
    return tuple(DepthError(one, Interval(*ends)) for one, ends in zip(metres, found.values(), strict=True))


def _shown(estimated: Estimate, best: Float[np.ndarray, "n"]) -> list[float]:
    """The distances [m] near, in the middle and far of what the images show, to one digit."""
    chart, shown = estimated.chart, estimated.shown
    depths = [share * float(chart.rig.baseline) for share in _BASELINES]
    if shown is not None:
        points, weights = points_shown(shown, chart, best, estimated.view)
        if len(points):
            order = np.argsort(points[:, 2])
            depths = np.interp(_SHARES, np.cumsum(weights[order]), points[order, 2]).tolist()
    farthest = DISTANCES[-1] * float(chart.rig.baseline)  # beyond, no matcher of a few baselines tells depth
    return sorted({float(f"{min(depth, farthest):.0e}") for depth in depths})


def as_distances(given: str | float | Sequence[str | float] | None) -> tuple[Distance, ...]:
    """Distances from "2m,50cm" or ("2m", 30), where a number alone is in baselines; none for None.

    Raises:
        InputError: if one is no distance.
    """
    if given is None:
        return ()
    parts = given.split(",") if isinstance(given, str) else [given] if isinstance(given, int | float) else given
    return tuple(dict.fromkeys(map(_distance, parts)))


def _distance(part: str | float) -> Distance:
    text = str(part).strip()
    unit = next((unit for unit in (*METRES, "B") if text.endswith(unit)), "")
    try:
        value = float(text.removesuffix(unit))
    except ValueError:
        value = float("nan")
    if not 0.0 < value < float("inf"):
        raise InputError(f"distances: {text!r} is none; give lengths, such as 2m or 50cm, or baselines, such as 30.")
    return value, unit or "B"


def distance_text(distances: Sequence[Distance]) -> str:
    """As they can be given again."""
    return ",".join(f"{value:g}{unit}" for value, unit in distances)
