"""The arguments of `python -m stereorecal reproduce`."""

import argparse

from stereorecal.cli.arguments._executors import EXECUTORS
from stereorecal.cli.arguments._matchers import add_matcher_to

_EXPERIMENTS = "validity, repair, generalise, ex-nihilo, sequential, all (default: all)"
_DESCRIPTION = """\
Run the paper's experiments on a log of missions: is the count highest under the right calibration (validity); repair
from a wrong one (repair); does a repair on one pair hold for the others (generalise); repair from the baseline alone
(ex-nihilo); repair pair after pair (sequential). Without a log, one is rendered. An interrupted run continues where it
stopped."""


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    parser = verbs.add_parser(
        "reproduce", parents=[common], help="run the paper's experiments", description=_DESCRIPTION
    )
    add = parser.add_argument
    add("experiments", nargs="*", default=["all"], metavar="EXPERIMENT", help=_EXPERIMENTS)
    add("--log", metavar="DIR", help="folder of missions, in any layout (documentation, page Your data)")
    add("--frames", metavar="N|all", help="first pairs of each sequence of --log (default: 10)")
    add(
        "--schedule",
        default="both",
        metavar="NAME",
        help="count (the paper's way), default (coarse to fine), or both (default: %(default)s)",
    )
    add_matcher_to(parser)
    add("--strategy", metavar="NAME", help="in place of compass, or of Levenberg-Marquardt if it needs residuals")
    add("--quick", action="store_true", help="a small log, few pairs: does everything work?")
    add("--reach", default="3,0.03", metavar="DEG,FRACTION", help="how far the rig may have drifted (default: 3,0.03)")
    add("--seed", type=int, default=0, help="same seed, same result (default: %(default)s)")
    add("--executor", default="serial", metavar="SPEC", help=EXECUTORS)
    add("--output", metavar="DIR", help="folder for tables and figures (default: reproduced/LOG)")
    add("--json", metavar="FILE|-", help="write everything as JSON there too")
    add("--force", action="store_true", help="--json may replace a file that is no input")
    add("--quiet", action="store_true", help="no progress and no tables")
    parser.set_defaults(verb="reproduce")
