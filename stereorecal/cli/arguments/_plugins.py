"""The arguments of a command about plug-ins of one kind."""

import argparse


def add_plugins_to(verbs, common: argparse.ArgumentParser, verb: str, kind: str) -> None:
    """Add the command `verb`, which lists the plug-ins of a kind or checks one, to an argparse subparsers object."""
    shared = [common]
    parser = verbs.add_parser(verb, parents=shared, help=f"list the installed {verb}, or check one")
    actions = parser.add_subparsers(metavar="ACTION")
    every = actions.add_parser("list", parents=shared, help=f"list the installed {verb} (the default)")
    every.set_defaults(action="list")
    check = actions.add_parser("check", parents=shared, help=f"run the conformance kit on a {kind}")
    check.add_argument("name")
    check.set_defaults(action="check")
    parser.set_defaults(verb=verb, action="list")
