"""How much memory a trial of the field takes, as its row says."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from stereorecal_field.judges import AbstractRecipe, Case, Draws, Judgement
from stereorecal_field.table import GOOD, AbstractMethod, Answer, compare_field, planned

import stereorecal as sr

RIG = sr.synthetic.default_rig().resized((160, 120))
PAIR = sr.Pair(*np.random.default_rng(0).uniform(0, 255, (2, 120, 160)).astype(np.float32))


@dataclass(frozen=True)
class Made(AbstractRecipe):
    judge: ClassVar[str] = "rendered"
    judged_by: ClassVar[str] = "by nothing"

    def make(self) -> Case:
        return Case(RIG, (PAIR,), "exact", lambda rig: Judgement(0.0, {10: 0.0, 30: 0.0}, None))


@dataclass(frozen=True)
class Hungry(AbstractMethod):
    """Takes 61 MiB."""

    @property
    def origin(self) -> str:
        return "tests"

    def solve(self, case, matcher, reach, seed) -> Answer:
        np.ones(8_000_000).sum()
        return Answer(case.start, GOOD, "full")


def memory(executor=None) -> float | None:
    tasks = planned([], [Made("s", 0, 0, 0, 0)], [Hungry("hungry")], matcher=None, draws=Draws(), reach=None)
    (trial,) = compare_field(*tasks, executor=executor).trials
    assert trial.message == "full"
    return trial.memory_mib


def test_memory_is_what_was_added():
    found = memory()
    assert found is None or 40 < found < 200


def test_memory_that_threads_share_is_not_said():
    with ThreadPoolExecutor(1) as pool:
        assert memory(pool) is None
