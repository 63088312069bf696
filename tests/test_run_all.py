"""Many tasks on any executor, by each door: the same answers, and what a worker or Ctrl-C loses costs no other task."""

import math
import pickle
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from threading import Event
from typing import Any

import pytest

import stereorecal as sr
from stereorecal.cli import run_all
from stereorecal.comparison import compare_scenes
from stereorecal.io import load_scene, save_scene
from stereorecal.recalibration import Fault, recalibrate_many

SMALL = {"matcher": sr.SAD(num_disparities=24), "budget": 5}


class Losing(ThreadPoolExecutor):
    """Loses the second task, as a cluster may lose a worker, cancels the third, and is broken from then on."""

    submitted = 0

    def submit(self, *task: Any, **options: Any) -> Future:
        self.submitted += 1
        lost: Future = Future()
        if self.submitted == 2:
            lost.set_exception(RuntimeError("the worker died"))
            return lost
        if self.submitted == 3:
            lost.cancel()
            lost.set_running_or_notify_cancel()
            return lost
        if self.submitted > 3:
            raise BrokenExecutor("the pool is broken")
        return super().submit(*task, **options)


class Done(ThreadPoolExecutor):
    """All tasks are finished before the first answer is looked at."""

    def submit(self, *task: Any, **options: Any) -> Future:
        future = super().submit(*task, **options)
        future.exception()
        return future


class Weighing(ThreadPoolExecutor):
    """Knows how many bytes its largest task takes on its way to another process, and that it arrives whole."""

    largest = 0

    def submit(self, *task: Any, **options: Any) -> Future:
        travelling = pickle.dumps(task)
        self.largest = max(self.largest, len(travelling))
        return super().submit(*pickle.loads(travelling), **options)


def spawned() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(1, mp_context=get_context("spawn"))


@pytest.mark.parametrize("pool", [ThreadPoolExecutor, spawned])
def test_any_pool_makes_the_same_of_them(pool):
    tasks = [4.0, 9.0, 16.0]
    with pool() as executor:
        assert dict(run_all(math.sqrt, tasks, executor)) == dict(run_all(math.sqrt, tasks, None)) == {0: 2, 1: 3, 2: 4}


def test_what_a_pool_loses_is_a_value():
    with Losing(1) as pool:
        found = dict(run_all(math.sqrt, [4.0] * 4, pool))
    assert found.pop(0) == 2.0
    said = ["the worker died", "the executor cancelled it: it was shut down, or has lost its workers."]
    assert [str(found[index]) for index in (1, 2, 3)] == [*said, "the pool is broken"]


def test_nothing_that_is_finished_is_lost_by_ctrl_c_in_a_worker():
    def worked(task: int) -> int:
        if task in (1, 3):
            raise KeyboardInterrupt
        return task

    finished = []
    with Done(1) as pool, pytest.raises(KeyboardInterrupt):
        finished.extend(run_all(worked, range(5), pool))
    assert sorted(finished) == [(0, 0), (2, 2), (4, 4)]


def test_who_stops_looking_cancels_what_waits():
    """The second task begins as the first ends; the third must not."""
    begun, stopped = [], Event()

    def work(task: int) -> None:
        begun.append(task)
        assert task == 0 or stopped.wait(60)

    with ThreadPoolExecutor(1) as pool:
        answers = run_all(work, range(20), pool)
        next(answers)
        answers.close()
        stopped.set()
    assert len(begun) <= 2


# --- by each door -------------------------------------------------------------------------------------------


def repaired(scene: sr.Scene, interrupted: bool = False, **options: Any) -> list[tuple[str | None, Any]]:
    """The results of three recordings: what went wrong, and the answer but for the time that it took."""
    finished: dict[int, Any] = {}
    scenes = [replace(scene, name=name) for name in ("one", "two", "three")]
    schedule = sr.Schedule.count("compass", 0.5)
    try:
        recalibrate_many(scenes, schedule=schedule, finished=finished.__setitem__, **SMALL, **options)
    except KeyboardInterrupt:
        assert interrupted
    return [(one.error, {**one.as_dict(), "seconds": None, "scene": None}) for _, one in sorted(finished.items())]


def compared(scene: sr.Scene, interrupted: bool = False, **options: Any) -> list[tuple[str | None, Any]]:
    """The results of three draws, likewise."""
    table = compare_scenes([scene], strategies=["compass"], draws=3, scale=0.5, **SMALL, **options)
    assert table.interrupted is interrupted
    return [(one.message if one.status == "FAILED" else None, replace(one, seconds=None)) for one in table.trials]


each_door = pytest.mark.parametrize("door", [repaired, compared])


@each_door
@pytest.mark.parametrize("pool", [lambda: ThreadPoolExecutor(2), pytest.param(spawned, marks=pytest.mark.slow)])
def test_answers_are_those_of_one_after_the_other(scene, door: Callable, pool: Callable):
    with pool() as executor:
        assert door(scene(), executor=executor) == door(scene())


@each_door
def test_a_lost_worker_is_an_error_of_its_task(scene, door: Callable):
    with Losing(1) as pool:
        first, second, third = door(scene(), executor=pool)
    assert first == door(scene())[0]
    assert "the worker died" in second[0]
    assert "cancelled it" in third[0]
    assert door is compared or second[1]["fault"] == Fault.INSIDE.name.lower()


@each_door
@pytest.mark.parametrize("pool", [nullcontext, lambda: ThreadPoolExecutor(1)])
def test_ctrl_c_keeps_what_is_finished(scene, door: Callable, pool: Callable):
    def stop(finished: int, total: int) -> None:
        assert total == 3
        raise KeyboardInterrupt

    with pool() as executor:
        (first,) = door(scene(), interrupted=True, executor=executor, progress=stop)
    assert first[0] is None


@pytest.fixture
def saved(scene, tmp_path: Path) -> sr.Scene:
    save_scene(scene(), tmp_path / "saved")
    return replace(load_scene(tmp_path / "saved"), reference="truth")


@each_door
def test_pairs_from_files_travel_as_paths(scene, saved: sr.Scene, door: Callable):
    for given, light in ((saved, True), (scene(), False)):
        with Weighing(1) as pool:
            assert [error for error, _ in door(given, executor=pool)] == [None] * 3
        assert pool.largest < 8_000 if light else pool.largest > 2 * 160 * 120


@pytest.mark.slow
@each_door
def test_a_worker_that_misses_an_image_says_so(saved: sr.Scene, tmp_path: Path, door: Callable):
    (tmp_path / "saved" / "left.png").unlink()
    with spawned() as pool:
        assert all("left.png" in error for error, _ in door(saved, executor=pool))
