"""What does the decision do with simulated calibrations? By kind of drift, one pair each; prints one table.

    python tests/benchmarks/decisions.py [--rigs N] [--first SEED] [--frames N] [--record FOLDER]

The rigs are those of `simulated_rigs.py` (even seeds unless --first is odd): calibrated by OpenCV on simulated boards,
drifted, seen through simulated correspondences, so that thousands can be counted. Nothing is searched or matched: what
is estimated, with the default prior and all free, is decided on as in `recalibrate`.

Harmful: accepted, and rows (root mean square over the view, on average over 5, 10 and 30 baselines) are worse by more
than 0.05 px (in brackets: 0.02), or depth at 30 baselines by more than a point: the median of |error| over the view, so
that errors that differ in sign, as those of a roll do, do not make up for each other. In need: rows above 0.2 px;
repaired: accepted without harm. Right: called good with nothing to win, or accepted without harm. Rows, depth: of what
is used in the end; medians.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import simulated_rigs
from recorded import NEED, ROWS_CHANGED, BySimulation, Case, simulated_errors
from tables import command_line, show, table_of

from stereorecal.decision import Reason, Seen, decide, reason_of
from stereorecal.estimation import estimate
from stereorecal.objectives import BASELINE

KINDS = (("none", 0.0), *((kind, d) for kind in simulated_rigs.DRIFTS[1:] for d in simulated_rigs.DEGREES))
SMALL = (0.1, 0.3, 0.5)  # degrees


def judged(seed: int, kind: str, degrees: float, frames: int, folder: Path | None = None) -> dict[str, float]:
    """One rig."""
    rig = simulated_rigs.simulated(seed, kind, degrees)
    correspondences = rig.correspondences(frames)
    found = estimate(correspondences, rig.calibrated)
    free = tuple(name for name in found.names if name != BASELINE)
    places = len(np.unique(np.asarray(correspondences.tile)))
    covered = correspondences.covered
    seen = Seen(correspondences.found, covered, places, texture=covered, misfit_px=max(found.misfit))
    bench, name, judge = f"simulated-{frames}", f"{seed} {kind} {degrees}", BySimulation(seed, kind, degrees)
    Case(bench, name, found, free, seen, rig.calibrated, judge).record(folder)
    decision = decide(found, free)
    reason = reason_of(decision, seen)
    before = simulated_errors(rig, rig.calibrated)
    after = simulated_errors(rig, found.chart.rig_at(decision.theta)) if reason.accepted else before
    harmful = after.worse_than(before)
    return {
        "good": reason is Reason.ALREADY_GOOD,
        "accepted": reason.accepted,
        "harmful": harmful,
        "changed": after.worse_than(before, ROWS_CHANGED),
        "need": before.rows[0] > NEED,
        "repaired": reason.accepted and not harmful,
        "right": reason.healthy and not harmful,
        "rows": after.rows[0],
        "depth": after.depth,
    }


def rows_of(of_kind: dict[tuple[str, float], list[dict[str, float]]]) -> Iterator[tuple[str, ...]]:
    """The rows of the table: each kind, then all, and all that drifted by little."""
    groups = {f"{kind} {degrees}°" if degrees else kind: found for (kind, degrees), found in of_kind.items()}
    groups["all"] = [one for found in of_kind.values() for one in found]
    small = [one for (_, degrees), found in of_kind.items() if degrees in SMALL for one in found]
    for name, found in {**groups, "0.1 to 0.5°": small}.items():
        by = {key: np.array([one[key] for one in found], float) for key in found[0]}
        needed = by["repaired"][by["need"] > 0]
        yield (
            name,
            str(len(found)),
            *(f"{100 * by[key].mean():.1f}" for key in ("good", "accepted", "right")),
            f"{int(by['harmful'].sum())} ({int(by['changed'].sum())})",
            f"{100 * needed.mean():.1f} of {len(needed)}" if len(needed) else "-",
            f"{np.median(by['rows']):.3f}",
            f"{np.median(by['depth']):.2f}",
        )


def main() -> None:
    """Simulate, decide, print."""
    parser = command_line(__doc__)
    parser.add_argument("--rigs", type=int, default=120)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--frames", type=int, default=1)
    parser.add_argument("--record", type=Path, help="a folder for replay.py")
    options = parser.parse_args()
    seeds = range(options.first, options.first + 2 * options.rigs, 2)
    of_kind = {kind: [judged(seed, *kind, options.frames, options.record) for seed in seeds] for kind in KINDS}
    heads = "drift | rigs | good % | accepted % | right % | harmful | repaired % of in need | rows px | depth %"
    table = table_of(heads)
    for row in rows_of(of_kind):
        table.add_row(*row)
    show(table)


if __name__ == "__main__":
    main()
