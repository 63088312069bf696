"""The arguments of `python -m stereorecal compare`."""

import argparse

from stereorecal.cli.arguments._executors import EXECUTORS
from stereorecal.cli.arguments._matchers import add_matcher_to


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    parser = verbs.add_parser(
        "compare",
        parents=[common],
        help="decalibrate rigs, and compare how strategies repair them",
        description="Decalibrate the rig of each scene several times, let every strategy repair each of them, and "
        "compare. Without a scene, one is rendered.",
    )
    add = parser.add_argument
    add("--scene", action="append", default=[], metavar="PATH", help="scene folder (repeatable)")
    add("--synthetic", metavar="KIND", help="render a scene: harbour, coast, open-sea, street")
    add(
        "--frames",
        action=_Given,
        default="1",
        metavar="N|all",
        help="pairs of each scene to use, jointly (default: %(default)s); of judges only those of rendered and "
        "simulated, the others have pairs of their own",
    )
    add_matcher_to(parser)
    add("--strategies", metavar="A,B|all", help="names of installed strategies (default: those of the schedule)")
    add(
        "--schedule",
        metavar="NAME",
        help="count (the paper's way: the count alone, at one scale) or default (coarse to fine); by default both, "
        "side by side, or count where --strategies is given",
    )
    add("--scale", type=float, help="image scale of the count schedule (default: 1)")
    add(
        "--decalibrate",
        default="0.5,0.01",
        metavar="DEG,FRACTION",
        help="largest drift of each axis (default: 0.5,0.01)",
    )
    add(
        "--reach",
        metavar="DEG,FRACTION",
        help="half width of the search box (default: 3,0.03, or 1.2 x the drift if that is more)",
    )
    add(
        "--free",
        default="extrinsics",
        metavar="NAME,…",
        help="what the strategies search: rotation, extrinsics, intrinsics, or single names (default: extrinsics)",
    )
    add("--draws", type=int, help="decalibrations of each scene (default: 2; of --preset field 10, and 4 drives)")
    add("--seed", type=int, default=0, help="same seed, same result (default: %(default)s)")
    add(
        "--budget",
        type=float,
        metavar="UNITS",
        help="of each trial; one unit: one matcher run on a full-size frame (default: no limit)",
    )
    add(
        "--judge",
        action="append",
        default=[],
        metavar="NAME[=PLACE]",
        help="compare methods by what none of them looks at (repeatable): lidar=FOLDER, boards=FOLDER, product=FOLDER, "
        "motion[=FOLDER], rendered[=KIND], simulated[=KIND], walk; only rows of lidar and of motion=FOLDER are of "
        "images that methods get, too; --strategies then names methods: the library's count, rows and motion, and "
        "strategies",
    )
    add("--preset", metavar="NAME", help="field: all judges that are rendered, and those of --judge, within an hour")
    add("--full", action="store_true", help="of --preset field: overnight")
    add("--board-corners", metavar="WxH", help="corners inside of the boards of --judge boards (default: 9x6)")
    add("--square", type=float, metavar="METRES", help="side of a square of those boards")
    add("--executor", default="serial", metavar="SPEC", help=EXECUTORS)
    add(
        "--json",
        metavar="FILE|-",
        help="write everything as JSON, again with each trial that is finished; of judges at the end, or at Ctrl-C, "
        "and until then finished trials are in FILE.trials, beside the first of --html and --json",
    )
    add("--html", metavar="FILE", help="write one HTML page with tables and figures, to pass on")
    add("--force", action="store_true", help="--json and --html may replace a file that is no input")
    add("--quiet", action="store_true", help="no progress and no table")
    parser.set_defaults(verb="compare", frames_given=False)


class _Given(argparse.Action):
    """Stores what was given, and that it was."""

    def __call__(self, parser, namespace, values, option_string=None):
        setattr(namespace, self.dest, values)
        setattr(namespace, f"{self.dest}_given", True)
