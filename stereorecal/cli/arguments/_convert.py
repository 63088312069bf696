"""The arguments of `python -m stereorecal convert`."""

import argparse

from stereorecal.cli.arguments._calibrations import FORMATS, add_reading_to

_DESCRIPTION = """\
Write a calibration in another format. Where a format has a file for each camera, name both as LEFT,RIGHT. Exit code: 0
done; 2 bad input, also where the format cannot hold the calibration: nothing is written then; 3 internal failure."""


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    parser = verbs.add_parser(
        "convert", parents=[common], help="write a calibration in another format", description=_DESCRIPTION
    )
    add = parser.add_argument
    add("source", metavar="A", help="calibration file, LEFT,RIGHT, or a folder that holds them")
    add("target", metavar="B", help="new file, or LEFT,RIGHT")
    add("--to", metavar="FORMAT", help=f"of B (default: stereorecal for .json, opencv for .yaml and .xml): {FORMATS}")
    add_reading_to(parser, "--from")
    add("--force", action="store_true", help="B may be replaced")
    add("--quiet", action="store_true", help="print nothing")
    parser.set_defaults(verb="convert")
