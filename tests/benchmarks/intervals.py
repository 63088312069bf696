"""Do the 95 % intervals cover the truth 95 times in a hundred, and are they no wider than they must be? Prints a table.

    python tests/benchmarks/intervals.py [--scenes N] [--first SEED] [--json FILE]

Rendered scenes of three kinds, each with its own seed (another scene, other noise), one drift each of up to 2.5° and
2.25 % of the baseline.
"""

import argparse
import json
from pathlib import Path

import jax
import numpy as np
from accuracy import AXES, errors
from rich.console import Console
from rich.table import Table

import stereorecal as sr

KINDS = ("harbour", "coast", "street")


def main() -> None:
    """Render, decalibrate, repair, count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--first", type=int, default=1000, help="seed of the first scene")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    rows = []
    for index in range(options.scenes):
        seed = options.first + index
        scene = sr.synthetic.render(KINDS[index % len(KINDS)], seed)
        start = sr.synthetic.decalibrate(scene.rig, jax.random.key(seed), 2.5, 0.0225)
        solution = sr.recalibrate(start, scene.pairs, prior="exact")
        known, error = solution.uncertainty, np.abs(errors(solution.candidate, scene.rig))
        row = {"scene": scene.name, "accepted": solution.accepted, "reason": solution.reason.name}
        if known is not None:
            row |= {"error": error.tolist(), "interval": known.interval.tolist(), "observed": known.observed.tolist()}
        rows.append(row)
        print(scene.name, solution.reason.name, np.round(error, 4).tolist(), flush=True)
        if options.json:
            options.json.write_text(json.dumps(rows))
    show(rows)


def show(rows: list[dict]) -> None:
    """One line for each axis, over the scenes where it is observed."""
    known = [row for row in rows if "error" in row]
    if not known:
        print("no scene has intervals")
        return
    error, interval, observed = (np.array([row[name] for row in known]) for name in ("error", "interval", "observed"))
    shown = Table(title=f"{len(known)} of {len(rows)} scenes, {sum(r['accepted'] for r in rows)} accepted", box=None)
    for head in ("axis", "observed", "covered", "median error", "median half width", "ratio"):
        shown.add_column(head, justify="left" if head == "axis" else "right")
    for axis, name in enumerate(AXES):
        here = observed[:, axis]
        off, half = error[here, axis], interval[here, axis]
        middle, width = np.median(off), np.median(half)
        cells = [
            f"{here.sum()}",
            f"{np.mean(off <= half):.1%}",
            f"{middle:.4f}",
            f"{width:.4f}",
            f"{width / middle:.1f}",
        ]
        shown.add_row(name, *cells)
    Console(width=100).print(shown)


if __name__ == "__main__":
    main()
