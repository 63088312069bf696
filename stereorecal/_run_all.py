"""Many tasks, one after the other or through an executor; a worker that is lost is a value, not an exception."""

import os
import pickle
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from dataclasses import dataclass
from typing import Any, TypeVar

from stereorecal._errors import InputError

Progress = Callable[[int, int], None]
Task = TypeVar("Task")
Result = TypeVar("Result")


def run_all(
    function: Callable[[Task], Result], tasks: Sequence[Task], executor: Executor | None
) -> Iterator[tuple[int, Result | BaseException]]:
    """The index of each task with what `function` makes of it, as they finish; an exception where the executor lost it.

    Without an executor, `function` runs here, and what it raises passes. A KeyboardInterrupt in a worker passes too,
    once what is finished has been handed out: Ctrl-C reaches workers as well, and is no result of a task. Closing the
    iterator, or an exception of its consumer, cancels the tasks that wait.

    Raises:
        InputError: if the executor forks its workers.
    """
    if executor is None:
        yield from ((index, function(task)) for index, task in enumerate(tasks))
        return
    futures: dict[Future[Result], int] = {}
    try:
        for index, task in enumerate(tasks):
            try:
                future = executor.submit(run_task, _Parcel(function, task))
            except BrokenExecutor as error:
                future = Future()
                future.set_exception(error)
            futures[future] = index
        unfinished = dict(futures)
        for future in as_completed(futures):
            index, found = unfinished.pop(future), _outcome(future)
            if isinstance(found, ForkedError):
                raise found
            if isinstance(found, KeyboardInterrupt):
                finished = [(index, _outcome(other)) for other, index in unfinished.items() if other.done()]
                yield from (one for one in finished if not isinstance(one[1], KeyboardInterrupt))
                raise found
            yield index, found
    finally:
        for future in futures:
            future.cancel()


class ForkedError(InputError):
    """A worker was forked."""


_PROCESS = os.getpid()  # that imported this module; a worker that was spawned imports it itself


@dataclass(frozen=True)
class _Parcel:
    """A function and its task, which travel as bytes and are unpickled only where they are opened.

    Otherwise those who hand them on unpickle them too: Dask's scheduler would read and keep the images of every task,
    and a process that misses an image would break the pool instead of saying so.
    """

    function: Callable[[Any], Any] | None  # None: it is in `task`, with the task, as bytes
    task: Any

    def __reduce__(self) -> tuple[Any, ...]:
        return _Parcel, (None, self.task if self.function is None else pickle.dumps((self.function, self.task)))


def run_task(parcel: _Parcel) -> Any:
    """Open the parcel, in a worker, and do what it says. Its name is what clusters call the task."""
    if os.getpid() != _PROCESS:
        raise ForkedError(
            "the executor forks its workers, in which JAX hangs; give "
            'ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")).'
        )
    if parcel.function is None:
        function, task = pickle.loads(parcel.task)
        return function(task)
    return parcel.function(parcel.task)


def _outcome(future: Future[Result]) -> Result | BaseException:
    try:
        return future.exception() or future.result()
    except CancelledError:
        return CancelledError("the executor cancelled it: it was shut down, or has lost its workers.")
