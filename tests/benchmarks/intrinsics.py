"""What freed intrinsics and ranges are worth, and what they may cost. Prints a table for each part.

    python tests/benchmarks/intrinsics.py [--rigs N] [--only PART,…]

Rendered rigs whose intrinsics are wrong as chessboards leave them (focal length 0.3 %, centre 1.5 px, k1 0.01, k2
0.02: one sigma, each camera by itself); eight scenes. Rows are those of points at ten baselines over the whole view, of
which no correspondence is known; depth is that straight ahead.

Rendered parts: one (all scenes share the extrinsics), each (each has its own), place (eight frames of one place),
ranges (one, with ten ranges of 1 % at 5 to 40 baselines), right (intrinsics that are right), baseline (its length from
100 ranges), expected (whether the intervals of depth and rows that a solution names hold).

Real ones, where STEREORECAL_DATA names a folder: bumblebee2 (intrinsics from some scenes, rows of the others), singles
(whether the intervals of single recordings reach the end point of all), suburb (the scatter of frames that share
intrinsics), good (intrinsics that are good already, freed).

long: 200 frames of 640x480 as a process of its own, with its time and its memory.
"""

import argparse
import os

import intrinsics_long
import intrinsics_real
import intrinsics_rendered
from rich.console import Console
from rich.table import Table

PARTS = (*intrinsics_rendered.REPAIRS, "baseline", "expected", *intrinsics_real.PARTS, "long")


def main() -> None:
    """Run the parts, print their tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--only", default=",".join(PARTS), help="parts, comma separated")
    options = parser.parse_args()
    parts = [part for part in PARTS if part in options.only.split(",")]
    table = Table(*intrinsics_rendered.HEADS, box=None)
    for part in parts:
        if part in intrinsics_rendered.REPAIRS:
            table.add_row(*intrinsics_rendered.repairs(part, options.rigs))
    if table.row_count:
        Console(width=140).print(table)
    if "baseline" in parts:
        intrinsics_rendered.baseline(options.rigs)
    if "expected" in parts:
        intrinsics_rendered.expectations(10 * options.rigs)
    for part in parts:
        if part in intrinsics_real.PARTS:
            if "STEREORECAL_DATA" in os.environ:
                intrinsics_real.PARTS[part]()
            else:
                print(f"{part}: set STEREORECAL_DATA")
    if "long" in parts:
        intrinsics_long.run()


if __name__ == "__main__":
    main()
