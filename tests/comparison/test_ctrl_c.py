"""Ctrl-C that reaches a worker: it passes, it is no internal error, and what is finished is kept."""

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from types import ModuleType

import pytest

from stereorecal.comparison import compare_scenes
from stereorecal.matching import SAD
from stereorecal.recalibration import Schedule, recalibrate_many

SMALL = {"matcher": SAD(num_disparities=24), "draws": 2, "scale": 0.5}

INTERRUPTED = """
from dataclasses import dataclass
from stereorecal.strategies import AbstractStrategy, Outcome, Status

@dataclass(frozen=True)
class Interrupted(AbstractStrategy):
    '''Ctrl-C arrives while it runs with one of these seeds.'''

    seeds: tuple[int, ...] = (0,)

    def run(self, objective, start, seed):
        if seed in self.seeds:
            raise KeyboardInterrupt
        objective.value(start)
        return Outcome(start, Status.STALLED)
"""


@pytest.fixture(scope="module")
def module(planted) -> ModuleType:
    return planted("interrupted_strategy", INTERRUPTED)


class Done(ThreadPoolExecutor):
    """All tasks are finished before the first answer is looked at."""

    def submit(self, fn, /, *args, **kwargs) -> Future:
        future = super().submit(fn, *args, **kwargs)
        future.exception()
        return future


def test_nothing_that_is_finished_is_lost(scene, module):
    strategies, five = {"slow": module.Interrupted(seeds=(1, 3))}, SMALL | {"draws": 5}
    with Done(1) as pool:
        table = compare_scenes([scene()], strategies=strategies, executor=pool, **five)
    assert table.interrupted
    assert [trial.draw for trial in table.trials] == [0, 2, 4]


def test_recalibrate_many(scene, module, pool):
    scenes = [replace(scene(), name=name) for name in ("one", "two")]
    schedule = Schedule.count(module.Interrupted(), 0.5)
    for executor in (pool, None):
        with pytest.raises(KeyboardInterrupt):
            recalibrate_many(scenes, matcher=SAD(num_disparities=24), schedule=schedule, executor=executor)


@pytest.mark.slow(after=1)
def test_compare_keeps_what_is_finished(scene, module, pool):
    table = compare_scenes([scene()], strategies={"slow": module.Interrupted(seeds=(1,))}, executor=pool, **SMALL)
    assert table.interrupted
    assert [(trial.draw, trial.status) for trial in table.trials] == [(0, "STALLED")]
