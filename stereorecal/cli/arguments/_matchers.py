"""The arguments of `python -m stereorecal matchers`, and the option that names one."""

import argparse

from stereorecal.cli.arguments._plugins import add_plugins_to


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    add_plugins_to(verbs, common, "matchers", "matcher")


def add_matcher_to(parser: argparse.ArgumentParser) -> None:
    """Add the option that says which matcher is used."""
    help_text = "an installed stereo matcher: sad, bm, sgbm, or a plug-in's (default: %(default)s)"
    parser.add_argument("--matcher", default="sad", metavar="NAME", help=help_text)
