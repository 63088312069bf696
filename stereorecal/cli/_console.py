"""Where tables go."""

import sys

from rich.console import Console

from stereorecal.report.tables import WIDE


def table_console(wide: int = WIDE) -> Console:
    """Stdout: as wide as the terminal, or `wide` columns where it is none."""
    return Console(width=None if sys.stdout.isatty() else wide)
