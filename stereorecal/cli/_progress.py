"""A progress bar where somebody looks."""

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from stereorecal._compile_cache import LOG
from stereorecal._run_all import Progress as ProgressCall

_COMPILING = "compiling, once for images of this size"


@contextmanager
def progress_bar(quiet: bool, doing: str = "repairing") -> Iterator[ProgressCall | None]:
    """A progress bar with the time that remains, on stderr, if that is a terminal; it says when a program is
    compiled that the next run will find in the cache."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(doing, total=None)
        with _on_compilation(lambda: bar.update(task, description=_COMPILING)):
            yield lambda finished, total: bar.update(task, description=doing, completed=finished, total=total)


@contextmanager
def _on_compilation(call: Callable[[], None]) -> Iterator[None]:
    """Call `call` whenever a program is compiled that is not in the cache."""

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            call()

    handler, level = Handler(), LOG.level
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.removeHandler(handler)
        LOG.setLevel(level)
