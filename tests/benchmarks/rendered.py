"""Whole repairs of rendered images, of rigs that were calibrated on boards and drifted; prints a table.

    python tests/benchmarks/rendered.py [--rigs N] [--first SEED] [--degrees D,…] [--frames N]

Rigs are those of `simulated_rigs.py` whose images are not rectified (even seeds unless --first is odd): 640x480 to
1280x720, baselines of 6 to 50 cm, calibrated by OpenCV on simulated boards, and drifted on all axes. Each sees another
rendered scene at each drift: a harbour, a coast or a street.

Harmful, in need: as `decisions.py` has it; missed: in need, and not accepted. Rows, depth: of what is used in the end;
medians. Held: whether the 95 % interval of depth at 30 baselines holds the truth, where one is stated.
"""

from dataclasses import dataclass

import numpy as np
from accuracy import MOVING
from recorded import simulated_errors
from simulated_rigs import Simulated, simulated
from tables import command_line, show, table_of, words

import stereorecal as sr

FAR = 30  # baselines


@dataclass(frozen=True)
class Row:
    """One repair."""

    accepted: bool
    harmful: bool
    need: bool
    rows: float
    depth: float
    held: float


def repaired(rig: Simulated, kind: str, seed: int, frames: int) -> Row:
    """The repair of what a rig sees."""
    scene = sr.synthetic.render(kind, seed, rig=rig.true_raw, frames=frames)
    solution = sr.recalibrate(rig.calibrated, scene.pairs)
    before, after = simulated_errors(rig, rig.calibrated), simulated_errors(rig, solution.rig)
    stated = solution.expected and solution.expected.depth_percent[FAR]
    (depth,) = rig.depth_error_percent(solution.rig, (FAR,))
    held = float(stated.low <= depth <= stated.high) if stated else np.nan
    row = Row(
        solution.accepted, after.worse_than(before), before.in_need, float(np.mean(after.rows)), after.depth, held
    )
    print(f"{rig.seed} {kind}", solution.reason.name, "harmful" * row.harmful, sep=" | ", flush=True)
    return row


def main() -> None:
    """Render, repair, judge, print."""
    parser = command_line(__doc__)
    parser.add_argument("--rigs", type=int, default=40, help="of which those take part that are not rectified")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--degrees", default="0,0.1,0.3,0.5,1,2.5")
    parser.add_argument("--frames", type=int, default=1)
    options = parser.parse_args()
    shown = table_of(f"drift | repairs | accepted | harmful | missed, of in need | rows px | depth at {FAR} B % | held")
    seeds, everything = range(options.first, options.first + 2 * options.rigs, 2), []
    for place, degrees in enumerate(map(float, words(options.degrees))):
        rigs = [simulated(seed, "all" if degrees else "none", degrees) for seed in seeds]
        found = [
            repaired(rig, MOVING[(rig.seed // 2 + place) % len(MOVING)], 10 * rig.seed + place, options.frames)
            for rig in rigs
            if not rig.rectified
        ]
        everything += found
        shown.add_row(f"{degrees:g}°", *cells(found))
    shown.add_row("all", *cells(everything))
    show(shown)


def cells(found: list[Row]) -> list[str]:
    """What there is to say of some repairs."""
    need = [one for one in found if one.need]
    return [
        f"{len(found)}",
        f"{sum(one.accepted for one in found)}",
        f"{sum(one.harmful for one in found)}",
        f"{sum(not one.accepted for one in need)} of {len(need)}",
        f"{np.median([one.rows for one in found]):.3f}",
        f"{np.median([one.depth for one in found]):.2f}",
        f"{np.nanmean([one.held for one in found]):.0%}",
    ]


if __name__ == "__main__":
    main()
