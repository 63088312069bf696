"""What a terminal shows: tables, lines and progress; rich is imported where there is any of it to show."""

import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from stereorecal._run_all import Progress as ProgressCall

if TYPE_CHECKING:
    from rich.console import Console

_WIDE = 120  # columns of a table that is not printed to a terminal


def table_console(wide: int = _WIDE) -> "Console":
    """Stdout: as wide as the terminal, or `wide` columns where it is none."""
    from rich.console import Console

    return Console(width=None if sys.stdout.isatty() else wide)


def print_lines(text: object) -> None:
    """Print lines. On a terminal, one that is too long is folded between words, and goes on indented; a file or a pipe
    gets it whole, as programs expect."""
    lines = str(text).splitlines()
    if sys.stdout.isatty():
        fold = textwrap.TextWrapper(table_console().width, subsequent_indent="  ", break_long_words=False)
        lines = [fold.fill(line) for line in lines]
    print("\n".join(lines))


@contextmanager
def progress_bar(quiet: bool, doing: str = "repairing") -> Iterator[ProgressCall | None]:
    """A progress bar with the time that remains, on stderr, if that is a terminal."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(doing, total=None)
        yield lambda finished, total: bar.update(task, completed=finished, total=total)
