"""What does the decision do with simulated calibrations? By kind of drift, one pair each; prints one table.

    python tests/benchmarks/decisions.py [--rigs N] [--first SEED] [--frames N]

The rigs are those of `simulated_rigs.py` (even seeds unless --first is odd): calibrated by OpenCV on simulated boards,
drifted, seen through simulated correspondences, so that thousands can be counted. Nothing is searched or matched: what
is estimated, with the default prior, is decided on as in `recalibrate`, which frees intrinsics where frames of several
places bear that out.

Good: it is called good. Harmful: accepted, and rows at 5, 10 or 30 baselines are worse by more than 0.02 px (root mean
square over the view), or depth at 30 baselines by more than a point: the median of |error| over the view. By |median|:
so many would be harmful if errors of depth that differ in sign over the view, as those of a roll do, made up for each
other. In need: rows at 30 baselines are misaligned by more than 0.2 px; repaired: accepted, and by 0.05 px better.
Right: called good with nothing to win, or accepted without harm. Depth: |error| at 30 baselines of what is used in the
end, of the candidate that keeps depth, and of the rig at the posterior's mean; medians.
"""

import argparse
from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import simulated_rigs
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.decision import DEFAULT, Verdict
from stereorecal.estimation import estimate
from stereorecal.objectives import EXTRINSICS
from stereorecal.recalibration._default_free import free_and_decision

KINDS = (("none", 0.0), *((kind, d) for kind in simulated_rigs.DRIFTS[1:] for d in simulated_rigs.DEGREES))
ROWS_AT, DEPTH_AT = (5.0, 10.0, 30.0), (30.0,)
WORSE_ROWS, WORSE_DEPTH, GAIN, NEED = 0.02, 1.0, 0.05, 0.2
SMALL = (0.1, 0.3, 0.5)  # degrees


def judged(seed: int, kind: str, degrees: float, frames: int) -> dict[str, float]:
    """One rig."""
    rig = simulated_rigs.simulated(seed, kind, degrees)
    correspondences = rig.correspondences(frames)
    seen = estimate(correspondences, rig.calibrated)
    free = sr.Parameters(widens=True)
    case = SimpleNamespace(free=free, tolerances=DEFAULT, rig=rig.calibrated, prior="default")
    freed, found = free_and_decision(case, correspondences, seen)
    kept, mean = (seen.chart.rig_at(theta) for theta in (seen.with_free(EXTRINSICS, keep_depth=True), seen.theta))
    used = rig.calibrated if found.refused else seen.chart.rig_at(found.theta)
    before, after = (rig.rows_px(one, ROWS_AT, rms=True) for one in (rig.calibrated, used))
    depth = [rig.absolute_depth_error_percent(one, DEPTH_AT)[0] for one in (rig.calibrated, used, kept, mean)]
    median = [abs(rig.depth_error_percent(one, DEPTH_AT)[0]) for one in (rig.calibrated, used)]
    accepted = not found.refused
    rows_worse = bool(np.any(after > before + WORSE_ROWS))
    harmful = accepted and (rows_worse or depth[1] > depth[0] + WORSE_DEPTH)
    return {
        "good": found.verdict is Verdict.GOOD,
        "accepted": accepted,
        "freed": accepted and bool(freed.intrinsics),
        "harmful": harmful,
        "by_median": accepted and (rows_worse or median[1] > median[0] + WORSE_DEPTH),
        "need": before[-1] > NEED,
        "repaired": accepted and after[-1] < before[-1] - GAIN,
        "right": found.verdict is Verdict.GOOD or (accepted and not harmful),
        "written": depth[1],
        "kept": depth[2],
        "mean": depth[3],
    }


def rows_of(of_kind: dict[tuple[str, float], list[dict[str, float]]]) -> Iterator[tuple[str, ...]]:
    """Of the table: each kind, then all, and all that drifted by little."""
    groups = {f"{kind} {degrees}°" if degrees else kind: found for (kind, degrees), found in of_kind.items()}
    groups["all"] = [one for found in of_kind.values() for one in found]
    small = [one for (_, degrees), found in of_kind.items() if degrees in SMALL for one in found]
    for name, found in {**groups, "0.1 to 0.5°": small}.items():
        by = {key: np.array([one[key] for one in found], float) for key in found[0]}
        needed = by["repaired"][by["need"] > 0]
        yield (
            name,
            str(len(found)),
            *(f"{100 * by[key].mean():.1f}" for key in ("good", "accepted", "freed", "right")),
            f"{int(by['harmful'].sum())} ({100 * by['harmful'].mean():.2f} %)",
            f"{int(by['by_median'].sum())}",
            f"{100 * needed.mean():.1f} of {len(needed)}" if len(needed) else "-",
            " ".join(f"{np.median(by[key]):.2f}" for key in ("written", "kept", "mean")),
        )


def main() -> None:
    """Simulate, decide, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=120)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--frames", type=int, default=1)
    options = parser.parse_args()
    seeds = range(options.first, options.first + 2 * options.rigs, 2)
    of_kind = {kind: [judged(seed, *kind, options.frames) for seed in seeds] for kind in KINDS}
    heads = ("drift", "rigs", "good %", "accepted %", "freed %", "right %", "harmful", "by |median|")
    table = Table(*heads, "repaired % of in need", "depth %: used, kept, mean", box=None)
    for row in rows_of(of_kind):
        table.add_row(*row)
    Console(width=160).print(table)


if __name__ == "__main__":
    main()
