"""What freed intrinsics and ranges are worth, and what they may cost. Prints a table for each part.

    python tests/benchmarks/intrinsics.py [--rigs N] [--only PART,…]

Rendered rigs whose intrinsics are wrong as chessboards leave them (focal length 0.3 %, centre 1.5 px, k1 0.01, k2
0.02: one sigma, each camera by itself); eight scenes. Rows are those of points at ten baselines over the whole view, of
which no correspondence is known; depth is that straight ahead. (Real rigs: truth.py --method library-free.)

one (all scenes share the extrinsics), each (each has its own), place (eight frames of one place), ranges (one, with ten
ranges of 1 % at 5 to 40 baselines), right (intrinsics that are right), baseline (its length from 100 ranges), expected
(whether the intervals of depth and rows that a solution names hold).

long: 200 frames of 640x480 as a process of its own, with its time and its memory.
"""

import intrinsics_long
from intrinsics_rendered import HEADS, REPAIRS, baseline, expectations, repairs
from tables import command_line, show, table_of, words

PARTS = (*REPAIRS, "baseline", "expected", "long")


def main() -> None:
    """Run the parts, print their tables."""
    parser = command_line(__doc__)
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--only", default=",".join(PARTS), help="parts, comma separated")
    options = parser.parse_args()
    parts, table = words(options.only), table_of(HEADS)
    for part in (part for part in REPAIRS if part in parts):
        table.add_row(*repairs(part, options.rigs))
    if table.row_count:
        show(table)
    if "baseline" in parts:
        baseline(options.rigs)
    if "expected" in parts:
        expectations(10 * options.rigs)
    if "long" in parts:
        intrinsics_long.run()


if __name__ == "__main__":
    main()
