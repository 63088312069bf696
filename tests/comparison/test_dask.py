"""A Dask cluster of two worker processes gives the same rows, whoever dies in the middle."""

from dataclasses import replace

import pytest
from distributed import LocalCluster
from parts_of_repairs import _cluster

from stereorecal.comparison import compare_scenes
from stereorecal.matching import SAD
from stereorecal.strategies import Budget, strategy

SMALL = {"schedule": "count", "matcher": SAD(num_disparities=24), "scale": 0.5, "budget": Budget(evaluations=10)}

DEADLY = """
import os, signal
from dataclasses import dataclass
from pathlib import Path
from stereorecal.strategies import AbstractStrategy, strategy

@dataclass(frozen=True)
class Deadly(AbstractStrategy):
    '''Compass search that kills its process on one draw; if there is a file to remember that, only once.'''

    draw: int = 0
    memory: str | None = None

    def run(self, objective, start, seed):
        if seed == self.draw and not (self.memory and Path(self.memory).exists()):
            if self.memory:
                Path(self.memory).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return strategy("compass").run(objective, start, seed)
"""


@pytest.fixture(scope="module")
def deadly(planted):
    return planted("deadly_strategy", DEADLY).Deadly


@pytest.fixture(scope="module")
def workers(deadly):
    """The cluster; its workers find compiled programs where all tests do."""
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster:
        yield cluster


def compared(workers, scene, draws, strategies, **options):
    workers.wait_for_workers(2)  # a nanny may be starting one again
    with _cluster.cluster(workers.scheduler_address) as pool:
        return compare_scenes([scene], strategies=strategies, draws=draws, executor=pool, **SMALL, **options)


def rows(table):
    return [replace(trial, seconds=None) for trial in table.trials]


@pytest.fixture(scope="module")
def serial(scene):
    """Six trials, whose strategy goes by the name that it has in the tests."""
    return rows(compare_scenes([scene()], strategies={"search": strategy("compass")}, draws=6, **SMALL))


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_nothing(workers, scene, serial, deadly, tmp_path):
    memory = tmp_path / "killed"
    table = compared(workers, scene(), 6, {"search": deadly(draw=2, memory=str(memory))})
    assert memory.exists()
    assert rows(table) == serial


@pytest.mark.slow
def test_a_trial_that_kills_every_worker_is_a_failed_row(workers, scene, serial, deadly, monkeypatch):
    monkeypatch.setattr(workers.scheduler, "allowed_failures", 1)
    found = rows(compared(workers, scene(), 2, {"search": deadly(draw=1)}))
    assert found[0] == serial[0]
    assert found[1].status == "FAILED"
    assert "all those workers died" in found[1].message


@pytest.mark.slow
def test_without_any_worker_left_the_rest_fails(workers, scene, serial, deadly, monkeypatch):
    monkeypatch.setattr(_cluster, "_PATIENCE_S", 0.5)
    workers.wait_for_workers(2)
    for nanny in workers.workers.values():
        nanny.close_gracefully()  # do not start again what dies
    found = rows(compared(workers, scene(), 4, {"search": deadly(draw=1)}))
    assert not workers.scheduler.workers
    assert found[1].status == "FAILED"
    assert found[1].message == "the executor cancelled it: it was shut down, or has lost its workers."
    assert all(row in serial for row in found if row.status != "FAILED")
