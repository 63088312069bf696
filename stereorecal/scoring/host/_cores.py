"""Work spread over the cores in pieces, since XLA runs a row scan on one core: candidates, frames, blocks of rows."""

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import jax

_here = threading.local()


def cores() -> int:
    """How many cores there are to spread over; 1 where something else than the CPU computes."""
    if jax.default_backend() != "cpu":
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def on_all_cores(function: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
    """`function` of each item, in order; several at a time, unless this is a piece of such work itself."""
    alone = len(items) < 2 or cores() < 2 or getattr(_here, "busy", False)
    return list((map if alone else _workers(os.getpid()).map)(function, items))


@cache
def _workers(process: int) -> ThreadPoolExecutor:
    """One thread for each core; cached, since a search runs many small batches. A fork has none of its parent's."""
    return ThreadPoolExecutor(cores(), initializer=setattr, initargs=(_here, "busy", True))
