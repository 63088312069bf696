"""The kit as a pytest class: the checks of the function, one test each."""

import inspect

import pytest

from stereorecal.strategies import AbstractStrategy, Outcome, Status, strategy
from stereorecal.testing import StrategyConformance, check_strategy


class TestCompass(StrategyConformance):
    strategy = strategy("compass")


class Idle(AbstractStrategy):
    def run(self, objective, start, seed):
        return Outcome(start, Status.STALLED)


def checks_of(kit: StrategyConformance):
    return {
        name.removeprefix("test_").replace("_", " "): test
        for name, test in inspect.getmembers(kit, inspect.ismethod)
        if name.startswith("test_")
    }


def test_every_check_is_a_test_with_a_sentence():
    tests = checks_of(TestCompass())
    assert set(tests) == {result.name for result in check_strategy(strategy("compass"))}
    assert all(test.__doc__ for test in tests.values())


def test_a_bad_strategy_fails_the_same_tests():
    class Bad(StrategyConformance):
        strategy = Idle()

    for result in check_strategy(Idle()):
        test = checks_of(Bad())[result.name]
        if result.passed:
            test()
        else:
            with pytest.raises(Exception, match=r".+"):
                test()
    assert not all(result.passed for result in check_strategy(Idle()))
