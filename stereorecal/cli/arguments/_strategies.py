"""The arguments of `python -m stereorecal strategies`."""

import argparse


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    shared = [common]
    parser = verbs.add_parser("strategies", parents=shared, help="list the installed strategies, or check one")
    actions = parser.add_subparsers(metavar="ACTION")
    every = actions.add_parser("list", parents=shared, help="list the installed strategies (the default)")
    every.set_defaults(action="list")
    check = actions.add_parser("check", parents=shared, help="run the conformance kit on a strategy")
    check.add_argument("name")
    check.set_defaults(action="check")
    parser.set_defaults(verb="strategies", action="list")
