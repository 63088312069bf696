"""What a terminal shows: tables, lines and progress; rich is imported where there is any of it to show."""

import logging
import re
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from stereorecal._compile_cache import LOG
from stereorecal._run_all import Progress as ProgressCall

if TYPE_CHECKING:
    from rich.console import Console

_WIDE = 120  # columns of a table that is not printed to a terminal
_COMPILING = "compiling, once for images of this size"


def table_console(wide: int = _WIDE) -> "Console":
    """Stdout: as wide as the terminal, or `wide` columns where it is none."""
    from rich.console import Console

    return Console(width=None if sys.stdout.isatty() else wide)


def print_lines(text: object) -> None:
    """Print lines. On a terminal, one that is too long is folded between words, below what its first word is about; a
    file or a pipe gets it whole, as programs expect."""
    lines = str(text).splitlines()
    if sys.stdout.isatty():
        width = table_console().width
        lines = [folded for line in lines for folded in _folded(line, width)]
    print("\n".join(lines))


@contextmanager
def progress_bar(quiet: bool, doing: str = "repairing") -> Iterator[ProgressCall | None]:
    """A progress bar with the time that remains, on stderr, if that is a terminal; it says when a program is
    compiled that the next run will find in the cache."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(doing, total=None)
        with _on_compilation(lambda: bar.update(task, description=_COMPILING)):
            yield lambda finished, total: bar.update(task, description=doing, completed=finished, total=total)


def _folded(line: str, width: int) -> list[str]:
    about = re.match(r"\S.{0,10}? {2,}", line)
    indent = " " * (about.end() if about is not None and about.end() < width // 3 else 2)
    together = re.sub(r"(?<=±) | (?=%)", "\u00a0", line)
    folded = textwrap.wrap(together, width, subsequent_indent=indent, break_long_words=False) or [""]
    return [one.replace("\u00a0", " ") for one in folded]


@contextmanager
def _on_compilation(call: Callable[[], None]) -> Iterator[None]:
    """Call `call` whenever a program is compiled that is not in the cache."""
    handler, level = logging.Handler(), LOG.level
    handler.emit = lambda record: call()
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.removeHandler(handler)
        LOG.setLevel(level)
