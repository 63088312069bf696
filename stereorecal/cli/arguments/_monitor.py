"""The arguments of `python -m stereorecal monitor`."""

import argparse

from stereorecal.cli.arguments._matchers import add_matcher_to
from stereorecal.cli.arguments._recordings import add_recordings_to
from stereorecal.cli.arguments._view import add_view_to

_DESCRIPTION = """\
Watch a rig over a recording, or while its cameras run, pair by pair: its health fused over time, knocks,
drift, late shutters; repair it, and switch to what wins on later pairs. A terminal shows a live view; else events are
lines. The calibration file stays as it is: a repaired one is written where --output says. Exit code: that of score, for
the calibration in use at the end: 0 healthy; 1 repair it; 2 bad input; 3 internal failure; 4 cannot tell; 130
interrupted."""


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    parser = verbs.add_parser(
        "monitor", parents=[common], help="watch a rig over a recording, and repair it", description=_DESCRIPTION
    )
    add_recordings_to(parser)
    add = parser.add_argument
    add(
        "--camera",
        nargs="+",
        metavar="NAME",
        help="watch cameras while they run, in place of a recording, with --calibration: numbers (0,1), devices, "
        "addresses, or GStreamer pipelines (two words); one that shows both images side by side; --tolerance as above",
    )
    add_matcher_to(parser)
    add_view_to(parser)
    add("--once", action="store_true", help="watch alone, switch nothing: a check of the calibration, for cron")
    add(
        "--state",
        metavar="FILE",
        help="go on from the state in this file, which is of this calibration; keep it there",
    )
    add(
        "--output",
        metavar="FILE",
        help="write the repaired calibration there, in the form in which it was read, if there is one",
    )
    add("--force", action="store_true", help="--output and --json may replace files (not a log that goes on)")
    add(
        "--json",
        metavar="FILE|-",
        help="write events and readings as JSON lines; append them if a --state goes on",
    )
    add("--quiet", action="store_true", help="show nothing, only the exit code")
    parser.set_defaults(verb="monitor")
