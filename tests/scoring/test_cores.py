"""Work spread over the cores: in order, one level deep, and errors come through."""

import threading

import pytest
from machine import cores

from stereorecal.scoring.host._cores import on_all_cores


@pytest.fixture(autouse=True)
def two_cores():
    with cores(2):
        yield


def test_order_is_kept_and_threads_are_used():
    seen = on_all_cores(lambda i: (i, threading.current_thread() is threading.main_thread()), range(20))
    assert [i for i, _ in seen] == list(range(20))
    assert not any(main for _, main in seen)


def test_a_piece_of_such_work_stays_on_its_thread():
    """Else pieces would wait for pieces, for ever."""

    def outer(i):
        here = threading.current_thread()
        return all(on_all_cores(lambda _: threading.current_thread() is here, range(5)))

    assert all(on_all_cores(outer, range(8)))


def test_errors_come_through():
    def fails(i):
        if i == 3:
            raise ValueError("three")
        return i

    with pytest.raises(ValueError, match="three"):
        on_all_cores(fails, range(6))
    assert on_all_cores(lambda i: i, range(3)) == [0, 1, 2]


def test_one_item_and_one_core_need_no_thread():
    assert on_all_cores(lambda _: threading.current_thread(), [0]) == [threading.main_thread()]
    with cores(1):
        assert set(on_all_cores(lambda _: threading.current_thread(), [0, 1])) == {threading.main_thread()}
