"""A Dask cluster as an executor."""

import asyncio
import logging
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager, suppress
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

from stereorecal._errors import InputError, extra

if TYPE_CHECKING:
    from distributed import Client

_ANSWER_S = 5.0  # within which a scheduler says who it is
_PATIENCE_S = 60.0  # that a cluster may be without a worker: a nanny restarts one in less


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """The executor of the Dask cluster whose scheduler is at `address` ("tcp://host:8786" or "host:8786").

    Dask runs a task again if its worker dies, and gives it up when it has taken several workers with it. It would wait
    for ever for a cluster without workers; here, what waits is cancelled after a minute."""
    with extra("dask", "--executor dask"):
        from dask import config
        from distributed import Client
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what becomes of a task is said by its result
    # Pairs made in memory make tasks above 10 MB, of which Dask would warn.
    with config.set({"distributed.admin.large-graph-warning-threshold": "1 TiB"}):
        _check_scheduler(address)
        client = Client(address, timeout=_ANSWER_S, set_as_default=False)
        pool, done = _Pool(client.get_executor(pure=False)), Event()
        Thread(target=_watch, args=(client, pool, done), daemon=True).start()
        try:
            yield pool
        finally:
            done.set()
            client.close()


class _Pool(Executor):
    """Dask's executor, with a way to give up all that is not finished."""

    def __init__(self, dask_executor: Executor):
        self._dask_executor = dask_executor
        self._futures: list[Future] = []

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        self._futures.append(self._dask_executor.submit(fn, *args, **kwargs))
        return self._futures[-1]

    def give_up(self) -> None:
        self._dask_executor.shutdown(wait=False)
        time.sleep(1.0)  # in which Dask cancels the futures, but for those whose result was just on its way
        for future in self._futures:
            if not future.done() and future.cancel():
                future.set_running_or_notify_cancel()


def _check_scheduler(address: str) -> None:
    """Ask who is there, before a Client does: that one waits for ever for a program that accepts and says nothing."""
    try:
        found = asyncio.run(asyncio.wait_for(_identity(address), _ANSWER_S))
    except Exception as error:  # whatever reading the bytes of another kind of server may raise
        raise InputError(
            f"no Dask scheduler answers at {address!r}; start one with: dask scheduler, and give its address, "
            "such as dask:tcp://host:8786."
        ) from error
    if "workers" not in found:
        raise InputError(f"at {address!r} is a Dask {found['type'].lower()}; give the address of the scheduler.")
    if not found["workers"]:
        raise InputError(f"the Dask scheduler at {address!r} has no workers; start some with: dask worker {address}")


async def _identity(address: str) -> Any:
    from distributed import rpc

    async with rpc(address) as server:
        return await server.identity()


def _watch(client: "Client", pool: _Pool, done: Event) -> None:
    """Until `done`: give up when no worker has been seen for too long."""
    last_seen = time.monotonic()
    while not done.wait(1.0):
        with suppress(Exception):  # whatever a lost connection raises
            if client.nthreads():
                last_seen = time.monotonic()
        if time.monotonic() - last_seen > _PATIENCE_S:
            pool.give_up()
            return
