"""Every strategy of the plug-in: it conforms, it is registered, it refuses options that make no sense."""

from dataclasses import fields

import numpy as np
import pytest
import stereorecal_nlopt

from stereorecal.strategies import Objective, Problem, describe, strategies, strategy
from stereorecal.testing import StrategyConformance

CLASSES = [value for value in vars(stereorecal_nlopt).values() if isinstance(value, type)]
NAMES = [name for name in strategies() if describe(name).distribution == "stereorecal-nlopt"]

# These differ from another one in nothing but NLopt's name of the method.
ALIKE = ("Cobyla", "Sbplx", "Lbfgs", "Ccsaq", "Mma", "TNewton", "Var2", "Direct", "DirectLRand", "Esch")

CONFORMANCE = {f"Test{c.__name__}": type(c.__name__, (StrategyConformance,), {"strategy": c()}) for c in CLASSES}
globals().update({name: pytest.mark.slow(c) if c.__name__ in ALIKE else c for name, c in CONFORMANCE.items()})
for alike in ("TestSlsqp", "TestAgs"):  # a rig by gradients: stereorecal-optimistix; without: NelderMead
    pytest.mark.slow(CONFORMANCE[alike].test_repairs_a_stereo_rig)


def test_every_strategy_is_registered():
    assert len(NAMES) == len(CLASSES) == 20
    assert {type(strategy(name)) for name in NAMES} == set(CLASSES)


@pytest.mark.parametrize("name", NAMES)
def test_it_says_in_one_sentence_what_it_is(name):
    summary = describe(name).summary
    assert summary.endswith(").")
    assert len(summary) < 115


BAD = {
    "step": (0.0, -0.1, 2.1, np.nan),
    "xtol": (0.0, -0.1, 2.0, np.nan),
    "ftol": (-0.1, 1.0, np.nan),
    "evaluations": (0, -1),
    "population": (-1,),
}


@pytest.mark.parametrize("cls", CLASSES)
def test_options_that_make_no_sense(cls):
    refused = 0
    for field in fields(cls):
        # Without tolerance CRS2 goes on until the budget is spent.
        for value in set(BAD[field.name]) - ({0.0} if cls is stereorecal_nlopt.Crs2 else set()):
            with pytest.raises(ValueError, match=f"need .*{field.name}.*, got"):
                cls(**{field.name: value})
            refused += 1
    assert refused >= 2


def test_a_population_too_small_for_the_dimension():
    objective = Objective(Problem(5, lambda points: -(points**2).sum(-1)))
    with pytest.raises(ValueError, match="NLopt refuses the options: population 5 should be >= dimension"):
        stereorecal_nlopt.Crs2(population=5).run(objective, np.zeros(5), 0)
