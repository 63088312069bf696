"""Where tables go."""

import sys

from rich.console import Console

from stereorecal.report.tables import WIDE


def table_console(wide: int = WIDE) -> Console:
    """Stdout: as wide as the terminal, or `wide` columns where it is none."""
    return _Console(width=None if sys.stdout.isatty() else wide)


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Called where rich has caught it, and would end the process: what is left to be saved would be lost."""
        raise  # noqa: PLE0704
