"""Do the 95 % intervals cover the truth 95 times in a hundred, and are they no wider than they must be? Prints a table.

    python tests/benchmarks/intervals.py

200 rendered scenes of three kinds, each with its own seed (another scene, other noise), one drift each of up to 2.5°
and 2.25 % of the baseline.
"""

import jax
import numpy as np
from accuracy import AXES, MOVING, errors
from tables import show, table_of

import stereorecal as sr

SCENES, FIRST = 200, 1000  # and the seed of the first one


def main() -> None:
    """Render, decalibrate, repair, count: a line for each axis, over the scenes where it is observed."""
    accepted, known = 0, []
    for index in range(SCENES):
        seed = FIRST + index
        scene = sr.synthetic.render(MOVING[index % len(MOVING)], seed)
        start = sr.synthetic.decalibrate(scene.rig, jax.random.key(seed), 2.5, 0.0225)
        solution = sr.recalibrate(start, scene.pairs, prior="exact")
        error, seen = np.abs(errors(solution.candidate, scene.rig)), solution.uncertainty
        accepted += solution.accepted
        if seen is not None:
            known.append((error, seen.interval, seen.observed))
        print(scene.name, solution.reason.name, np.round(error, 4).tolist(), flush=True)
    error, interval, observed = map(np.array, zip(*known, strict=True))
    shown = table_of(
        "axis | observed | covered | median error | median half width | ratio",
        title=f"{len(known)} of {SCENES} scenes, {accepted} accepted",
    )
    for axis, name in enumerate(AXES):
        here = observed[:, axis]
        off, half = error[here, axis], interval[here, axis]
        middle, width = np.median(off), np.median(half)
        cells = (f"{np.mean(off <= half):.1%}", f"{middle:.4f}", f"{width:.4f}", f"{width / middle:.1f}")
        shown.add_row(name, f"{here.sum()}", *cells)
    show(shown)


if __name__ == "__main__":
    main()
