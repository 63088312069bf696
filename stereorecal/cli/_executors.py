"""Who does the work of a command: this process, threads, processes, or a cluster."""

from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from multiprocessing import get_context
from signal import SIG_IGN, SIGINT, signal

from stereorecal._errors import InputError
from stereorecal._names import known
from stereorecal.cli._cluster import cluster
from stereorecal.cli._compiled import keep_compiled_programs


def executor(text: str) -> AbstractContextManager[Executor | None]:
    """A context with the executor that one of EXECUTORS stands for; None for serial.

    Raises:
        InputError: if `text` is none of them, or no cluster answers there.
    """
    kind, _, rest = text.partition(":")
    known(kind, ["serial", "threads", "processes", "dask"], "executor")
    if kind == "serial":
        return nullcontext()
    if kind == "dask":
        return cluster(rest)
    if not rest.isdecimal() or int(rest) < 1:
        raise InputError(f"--executor is {text!r}; give the number of workers, such as {kind}:2.")
    if kind == "threads":
        return _pool(ThreadPoolExecutor(int(rest)))
    # Forking after JAX has started threads is unsafe.
    return _pool(ProcessPoolExecutor(int(rest), mp_context=get_context("spawn"), initializer=_begin_work))


@contextmanager
def _pool(pool: ThreadPoolExecutor | ProcessPoolExecutor) -> Iterator[Executor]:
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _begin_work() -> None:
    """In a worker process: Ctrl-C is left to the parent."""
    signal(SIGINT, SIG_IGN)
    keep_compiled_programs()
