"""Rendered drives for `motion.py`: what comes of images, where tracks alone come of a simulation."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import jax
from tables import show, table_of

import stereorecal as sr
from stereorecal.estimation import points_of_view, readings
from stereorecal.synthetic import photographs, plan_drive

TOURS = ("street", "harbour")
PAIRS = 9
EVERY = {"street": 3, "harbour": 6}  # frames from one pair to the next: about a baseline
STARTS = ((0.0, 0.0), (0.3, 0.0), (2.5, 0.0), (0.3, 0.2))  # degrees, and how late, of the time between two pairs


def depth_error_percent(used: sr.StereoRig, true: sr.StereoRig, baselines: float = 30.0) -> float:
    """Of the depth that a rig reads, over the view, on average; positive: too far."""
    near = float(readings(used, true, points_of_view(true, baselines))[1].mean())
    return 100.0 * (1.0 / (1.0 + near) - 1.0)


def taken(tour: str, seed: int, late: float, size: tuple[int, int]) -> tuple[sr.StereoRig, Sequence[sr.Pair]]:
    """The true rig and some of the pairs of a drive in clear weather, on which things move."""
    every = EVERY[tour]
    number = (PAIRS - 1) * every + 1
    plan = plan_drive(tour, seed, number, weather=False, late=((0, number, late * every),) if late else ())
    plan = replace(plan, rig=plan.rig.resized(size))
    return plan.truth(number // 2), [pair for frame, pair in enumerate(photographs(plan)) if frame % every == 0]


def rendered(seeds: Sequence[int], size: tuple[int, int]) -> None:
    """A table of repairs."""
    table = table_of(
        "drive | from | late by | verdict | |depth error| at 30 B, %: before | written | posterior's mean: 95 % | rows "
        "| delay",
        left=4,
    )
    for tour, seed, (degrees, late) in product(TOURS, seeds, STARTS):
        true, pairs = taken(tour, seed, late, size)
        given = sr.synthetic.decalibrate(true, jax.random.key(seed), degrees, 0.009 * degrees)
        found = sr.recalibrate(given, pairs, motion=True)
        seen, rows = found.estimate, found.row_errors
        assert seen is not None
        assert rows is not None
        _, low, high = seen.depth_error_percent(seen.theta)[30]
        delay = seen.delay
        table.add_row(
            f"{tour} {seed}",
            f"{degrees:g}°",
            f"{late:g}",
            found.reason.name,
            f"{abs(depth_error_percent(given, true)):.1f}",
            f"{abs(depth_error_percent(found.rig, true)):.2f}",
            f"{depth_error_percent(seen.chart.rig_at(seen.theta), true):+.2f}: {low:+.1f} {high:+.1f}",
            f"{rows.before:.2f} {rows.after:.2f}",
            f"{delay.seconds:+.3f}" if delay and delay.probability > 0.5 else "",
        )
    show(table)
