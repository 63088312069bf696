"""Do the stated intervals hold the truth? Simulated calibrations, by kind of drift; prints one table.

    python tests/benchmarks/coverage.py [--rigs N] [--first SEED]

The rigs are those of `simulated_rigs.py` (even seeds unless --first is odd): calibrated with OpenCV on simulated
corners, drifted, seen through simulated correspondences. Of the rig at the posterior's mean: how often the 95 %
intervals of its depth and of the extrinsics hold the truth, the median epipolar error over the view and the median
depth error, and the mean interval score (Gneiting & Raftery 2007) of depth at 30 baselines beside that of the best
interval of constant width, which knows all truths.
"""

import numpy as np
import simulated_rigs
from simulated_rigs import AXES
from tables import command_line, show, table_of

from stereorecal.estimation import Estimate, estimate

KINDS = (("none", 0.0), ("all", 0.1), ("all", 0.3), ("all", 2.5), ("yaw", 0.3), ("pitch", 0.3), ("roll", 0.3))
DISTANCES = (5, 10, 30, 100)
MISS = 2.0 / 0.05  # what a miss costs in an interval score of 95 %


def judged(seed: int) -> list[dict[str, np.ndarray]]:
    """The rig of a seed after each kind of drift."""
    rigs = [simulated_rigs.simulated(seed, *kind) for kind in KINDS]
    return [measured(rig, estimate(rig.correspondences(), rig.calibrated)) for rig in rigs]


def measured(rig: simulated_rigs.Simulated, seen: Estimate) -> dict[str, np.ndarray]:
    """One rig."""
    used = seen.chart.rig_at(seen.theta)
    depth, rows = rig.depth_error_percent(used, DISTANCES), rig.rows_px(used, DISTANCES)
    before = rig.depth_error_percent(rig.calibrated, DISTANCES)
    ends = np.array([seen.depth_error_percent(seen.theta)[distance][1:] for distance in DISTANCES])
    low, high = (100.0 * (1.0 / (1.0 + end / 100.0) - 1.0) for end in (ends[:, 1], ends[:, 0]))  # of nearness: bounded
    near = 100.0 * (1.0 / (1.0 + np.array(depth) / 100.0) - 1.0)
    score = (high - low) + MISS * (np.maximum(low - near, 0.0) + np.maximum(near - high, 0.0))
    axes = np.full(len(AXES), np.nan)
    if not rig.rectified:  # no plain rig is the truth there
        shift, baseline = np.array(rig.true_raw.extrinsics), float(rig.calibrated.baseline)
        shift[3:] *= baseline / np.linalg.norm(shift[3:])
        moved = shift - np.array(rig.calibrated.extrinsics)
        truth = np.r_[np.degrees(moved[:3]), 100.0 * moved[4:] / baseline]
        ends = seen.intervals[[seen.names.index(axis) for axis in AXES]]
        axes = (truth >= ends[:, 0]) & (truth <= ends[:, 1])
    return {
        "depth": (near >= low) & (near <= high),
        "axes": axes,
        "rows": np.array(rows),
        "error": np.abs(depth),
        "grown": np.abs(depth)[2] > np.abs(before)[2] + 1.0,
        "score": score[2],
        "near": near[2],
    }


def main() -> None:
    """Simulate, judge, print."""
    parser = command_line(__doc__)
    parser.add_argument("--rigs", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    table = table_of(
        f"drift | rigs | depth held, 10 30 B | axes held: {' '.join(AXES)} | rows px, 5 10 30 100 B "
        "| |depth error| %, 5 10 30 100 B | grown by a point at 30 B"
    )
    seeds = range(options.first, options.first + 2 * options.rigs, 2)
    of_seeds = [judged(seed) for seed in seeds]
    every = [one for found in of_seeds for one in found]
    for (kind, degrees), found in zip(KINDS, zip(*of_seeds, strict=True), strict=True):
        whole = {name: np.array([one[name] for one in found], float) for name in found[0]}
        table.add_row(
            f"{kind} {degrees:g}°" if degrees else kind,
            f"{len(found)}",
            " ".join(f"{100 * share:.0f}" for share in whole["depth"].mean(0)[1:3]),
            " ".join(f"{100 * share:.0f}" for share in np.nanmean(whole["axes"], 0)),
            " ".join(f"{pixels:.3f}" for pixels in np.median(whole["rows"], 0)),
            " ".join(f"{error:.2f}" for error in np.median(whole["error"], 0)),
            f"{100 * whole['grown'].mean():.1f} %",
        )
    show(table)
    near = np.abs([one["near"] for one in every])
    widths = np.arange(0.25, 100.0, 0.25)
    constant = min(float(np.mean(2.0 * w + MISS * np.maximum(near - w, 0.0))) for w in widths)
    print(f"mean interval score {np.mean([one['score'] for one in every]):.2f}, of the best constant {constant:.2f}")


if __name__ == "__main__":
    main()
