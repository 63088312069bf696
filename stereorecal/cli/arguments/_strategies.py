"""The arguments of `python -m stereorecal strategies`."""

import argparse

from stereorecal.cli.arguments._plugins import add_plugins_to


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    add_plugins_to(verbs, common, "strategies", "strategy")
