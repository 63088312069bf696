"""Who does the work of a command: this process, threads, processes, or a cluster."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait
from typing import Any

from stereorecal._errors import checked_choice
from stereorecal.cli._cluster import cluster
from stereorecal.cli._jax_setup import use_compile_cache
from stereorecal.cli._option_values import of_form


def executor(text: str) -> AbstractContextManager[Executor | None]:
    """A context with the executor that one of EXECUTORS stands for; None for serial.

    Raises:
        InputError: if `text` is none of them, or no cluster answers there.
    """
    if text == "serial":
        return nullcontext()
    kind, _, rest = text.partition(":")
    checked_choice(kind, ["threads", "processes", "dask"], "executor")
    if kind == "dask":
        return cluster(rest)
    workers = of_form(r"\w+:0*([1-9]\d{0,8})", f"the number of workers, such as {kind}:2", int)(text, "--executor")
    if kind == "threads":
        return _pool(ThreadPoolExecutor(workers))
    # Who is interrupted leaves semaphores to Python's tracker of such things, which removes them and need not complain.
    os.environ.setdefault("PYTHONWARNINGS", "ignore:resource_tracker:UserWarning")
    # Forking after JAX has started threads is unsafe.
    return _pool(_Processes(workers, mp_context=get_context("spawn"), initializer=_begin_work))


class _Processes(ProcessPoolExecutor):
    """Worker processes that leave all that ends a run to their parent from their first moment on: a signal that reaches
    the whole group would else break the pool while the parent cancels what waits in it."""

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        if not hasattr(signal, "pthread_sigmask"):  # Windows
            return super().submit(fn, *args, **kwargs)
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP, signal.SIGTERM})
        try:
            return super().submit(fn, *args, **kwargs)  # starts a worker, which inherits what is blocked
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _pool(pool: ThreadPoolExecutor | ProcessPoolExecutor) -> Iterator[Executor]:
    earlier_processes = set(active_children())
    try:
        yield pool
    finally:
        # Everything is saved. Who still works was interrupted: nobody waits for what he makes.
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in set(active_children()) - earlier_processes:
            worker.kill()


def _begin_work() -> None:
    """Begin a worker process: what ends a run is left to the parent, without whom nobody works."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if (parent := parent_process()) is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    use_compile_cache()


def _end_with(sentinel: int) -> None:
    """End at once when the parent has: killed, it could not end its workers."""
    wait([sentinel])
    os._exit(1)
