"""BLAS has one thread inside, and outside as many as before, however threads come and go."""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings, strategies as st
from threadpoolctl import ThreadpoolController, threadpool_info

from stereorecal.estimation import estimate, one_blas_thread

BEFORE = 2
assert scipy.linalg  # has a BLAS of its own


def threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


def _elsewhere(do: Callable[[], None]) -> None:
    """In a thread that ends: what it set stays, and others may set it again."""
    thread = threading.Thread(target=do)
    thread.start()
    thread.join()


@pytest.fixture(scope="module", autouse=True)
def _several() -> Iterator[None]:
    libraries = ThreadpoolController().select(user_api="blas").lib_controllers
    before = [library.num_threads for library in libraries]

    def set_to(numbers: list[int]) -> None:
        for library, number in zip(libraries, numbers, strict=True):
            library.set_num_threads(number)

    _elsewhere(lambda: set_to([BEFORE] * len(libraries)))
    assert threads() == {BEFORE}
    yield
    _elsewhere(lambda: set_to(before))


@settings(max_examples=15, deadline=None)
@given(order=st.permutations([0, 1, 2] * 2))
def test_threads_that_come_and_leave_one_after_the_other(order):
    """Each of three comes and leaves once; whoever is alone when coming, sets it and takes it back."""
    inside: set[int] = set()
    holder = None
    steps, done = {who: threading.Semaphore(0) for who in set(order)}, threading.Semaphore(0)

    def visit(who: int) -> None:
        steps[who].acquire()
        with one_blas_thread():
            done.release()
            steps[who].acquire()
        done.release()

    for who in steps:
        threading.Thread(target=visit, args=(who,), daemon=True).start()
    for who in order:
        steps[who].release()
        assert done.acquire(timeout=10)
        if who not in inside and holder is None:
            holder = who
        elif who == holder:
            holder = None
        inside ^= {who}
        assert threads() == ({BEFORE} if holder is None else {1})
    assert threads() == {BEFORE}


def test_errors_leave_it_as_it_was():
    with pytest.raises(np.linalg.LinAlgError), one_blas_thread():
        np.linalg.cholesky(-np.eye(2))
    assert threads() == {BEFORE}


def test_inside_of_itself():
    with one_blas_thread():
        with one_blas_thread():
            assert threads() == {1}
        assert threads() == {1}
    assert threads() == {BEFORE}


def test_estimates_in_several_threads_are_those_of_one(rig, chart, seen):
    found = [seen(rig, chart.rig_at(0.1 * np.eye(chart.dim)[axis]), axis) for axis in range(3)]

    def whole(one) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        given = estimate(one, rig, "exact")
        return given.theta, given.intervals, given.with_free(chart.names[:5])

    expected = [whole(one) for one in found]
    with ThreadPoolExecutor(3) as pool:
        for ours, theirs in zip(pool.map(whole, found), expected, strict=True):
            for one, other in zip(ours, theirs, strict=True):
                np.testing.assert_allclose(one, other, atol=1e-9)
    assert threads() == {BEFORE}
