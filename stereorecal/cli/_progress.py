"""A progress bar where somebody looks."""

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from stereorecal._kept import LOG
from stereorecal._run_all import Progress as ProgressCall

_COMPILING = "compiling, once for images of this size"


@contextmanager
def progress_bar(quiet: bool, doing: str = "repairing") -> Iterator[ProgressCall | None]:
    """A progress bar with the time that remains, on stderr, if that is a terminal; it says when a program is compiled
    that the next run will find."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(doing, total=None)
        with _told(lambda: bar.update(task, description=_COMPILING)):
            yield lambda finished, total: bar.update(task, description=doing, completed=finished, total=total)


@contextmanager
def _told(say: Callable[[], None]) -> Iterator[None]:
    """Call `say` whenever a program is made that was not kept."""

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            say()

    handler, level = Handler(), LOG.level
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.removeHandler(handler)
        LOG.setLevel(level)
