"""BLAS on one thread, while a rig is estimated.

That solves hundreds of small systems: threads would wait for each other, and for other processes on these cores. The
limit is that of the whole process, and only the thread that set it can be relied on to take it back.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController

_holds = threading.Lock()


@cache
def _controller() -> ThreadpoolController:
    """The controller of the libraries that are loaded: searching for them takes milliseconds."""
    return ThreadpoolController()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """One thread inside, and outside as many as before. The first who is inside sets the limit and takes it back;
    others that are there at the same time, or deeper inside, go on as it is: at worst they are slower."""
    if not _holds.acquire(blocking=False):
        yield
        return
    try:
        with _controller().limit(limits=1, user_api="blas"):
            yield
    finally:
        _holds.release()
