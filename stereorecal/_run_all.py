"""Many tasks, one after the other or through an executor; a worker that is lost is a value, not an exception."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from typing import TypeVar

Progress = Callable[[int, int], None]
Task = TypeVar("Task")
Result = TypeVar("Result")


def run_all(
    function: Callable[[Task], Result], tasks: Sequence[Task], executor: Executor | None
) -> Iterator[tuple[int, Result | BaseException]]:
    """The index of each task with what `function` makes of it, as they finish; an exception where the executor lost it.

    Without an executor, `function` runs here, and what it raises passes. Closing the iterator, or an exception of its
    consumer, cancels the tasks that wait.
    """
    if executor is None:
        yield from ((index, function(task)) for index, task in enumerate(tasks))
        return
    futures = {_submitted(executor, function, task): index for index, task in enumerate(tasks)}
    try:
        for future in as_completed(futures):
            yield futures[future], _outcome(future)
    finally:
        for future in futures:
            future.cancel()


def _submitted(executor: Executor, function: Callable[[Task], Result], task: Task) -> Future[Result]:
    try:
        return executor.submit(function, task)
    except BrokenExecutor as error:
        lost: Future[Result] = Future()
        lost.set_exception(error)
        return lost


def _outcome(future: Future[Result]) -> Result | BaseException:
    try:
        error = future.exception()
    except CancelledError as cancelled:
        error = cancelled
    return future.result() if error is None else error
