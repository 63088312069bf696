"""The kit as a pytest class: the checks of the function, one test each."""

import inspect

from stereorecal.strategies import strategy
from stereorecal.testing import StrategyConformance, check_strategy


def test_every_check_is_a_test_with_a_sentence():
    """(What bad strategies fail is held in test_kit, by the function.)"""

    class Compass(StrategyConformance):
        strategy = strategy("compass")

    tests = {
        name.removeprefix("test_").replace("_", " "): test
        for name, test in inspect.getmembers(Compass(), inspect.ismethod)
        if name.startswith("test_")
    }
    assert set(tests) == {result.name for result in check_strategy(strategy("compass"))}
    assert all(test.__doc__ for test in tests.values())
