"""Many tasks, one after the other or through an executor; a worker that is lost is a value, not an exception."""

import os
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from stereorecal._errors import InputError

Progress = Callable[[int, int], None]
Task = TypeVar("Task")
Result = TypeVar("Result")


def run_all(
    function: Callable[[Task], Result], tasks: Sequence[Task], executor: Executor | None
) -> Iterator[tuple[int, Result | BaseException]]:
    """The index of each task with what `function` makes of it, as they finish; an exception where the executor lost it.

    Without an executor, `function` runs here, and what it raises passes. A KeyboardInterrupt in a worker passes too,
    once what is finished by then has been handed out: Ctrl-C reaches workers as well, and is no result of a task.
    Closing the iterator, or an exception of its consumer, cancels the tasks that wait.

    Raises:
        InputError: if the executor forks its workers.
    """
    if executor is None:
        yield from ((index, function(task)) for index, task in enumerate(tasks))
        return
    futures = {_submitted(executor, _Parcel(function, task)): index for index, task in enumerate(tasks)}
    unfinished = dict(futures)
    try:
        for future in as_completed(futures):
            found = _outcome(future)
            if isinstance(found, ForkedError):
                raise found
            if isinstance(found, KeyboardInterrupt):
                yield from _completed(unfinished)
                raise found
            yield unfinished.pop(future), found
    finally:
        for future in futures:
            future.cancel()


class ForkedError(InputError):
    """A worker was forked."""


_PROCESS = os.getpid()  # that imported this module; a worker that was spawned imports it itself
_FORKED = (
    "the executor forks its workers, in which JAX hangs; give "
    'ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")).'
)


@dataclass(frozen=True)
class _Parcel(Generic[Task, Result]):
    """A function and its task, which travel as bytes and are unpickled only where they are opened.

    Otherwise those who hand them on unpickle them too: Dask's scheduler would read and keep the images of every task,
    and a process that misses an image would break the pool instead of saying so.
    """

    function: Callable[[Task], Result]
    task: Task

    def opened(self) -> tuple[Callable[[Task], Result], Task]:
        return self.function, self.task

    def __reduce__(self) -> tuple[Any, ...]:
        return _Packed, (pickle.dumps(self.opened()),)


@dataclass(frozen=True)
class _Packed:
    """A parcel that has travelled."""

    content: bytes

    def opened(self) -> Any:
        return pickle.loads(self.content)


def run_task(parcel: _Parcel[Task, Result] | _Packed) -> Result:
    """In a worker: open the parcel and do what it says. Its name is what clusters call the task.

    Raises:
        ForkedError: if this process is a fork of one that had JAX: it would hang.
    """
    if os.getpid() != _PROCESS:
        raise ForkedError(_FORKED)
    function, task = parcel.opened()
    return function(task)


def _submitted(executor: Executor, parcel: _Parcel[Task, Result]) -> Future[Result]:
    try:
        return executor.submit(run_task, parcel)
    except BrokenExecutor as error:
        lost: Future[Result] = Future()
        lost.set_exception(error)
        return lost


def _completed(futures: Mapping[Future[Result], int]) -> Iterator[tuple[int, Result | BaseException]]:
    for future, index in futures.items():
        if future.done() and not isinstance(found := _outcome(future), KeyboardInterrupt):
            yield index, found


def _outcome(future: Future[Result]) -> Result | BaseException:
    try:
        error = future.exception()
    except CancelledError:
        error = CancelledError("the executor cancelled it: it was shut down, or has lost its workers.")
    return future.result() if error is None else error
