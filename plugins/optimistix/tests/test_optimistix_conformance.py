"""Every strategy of the distribution conforms, and is found by its name."""

import inspect
from importlib.metadata import distribution

import pytest
import stereorecal_optimistix

from stereorecal.strategies import AbstractStrategy, describe, strategy
from stereorecal.testing import StrategyConformance

POINTS = [p for p in distribution("stereorecal-optimistix").entry_points if p.group == "stereorecal.strategies"]

# These differ from BFGS or LevenbergMarquardt in nothing but Optimistix's solver.
ALIKE = ("LBFGS", "NonlinearCG", "GradientDescent", "GaussNewton", "Dogleg")

for point in POINTS:
    cls = point.load()
    name = f"Test{cls.__name__}"
    made = type(name, (StrategyConformance,), {"strategy": cls()})
    globals()[name] = pytest.mark.slow(made) if cls.__name__ in ALIKE else made

# A rig by its gradients or without: stereorecal-nlopt. How Optimistix's solvers climb what is neither smooth nor a
# staircase is their own. (Each class has test functions of its own.)
for name in ("TestAdam", "TestBFGS", "TestNelderMead"):
    for check in ("repairs_a_stereo_rig", "climbs_a_tilted_ridge", "climbs_a_noisy_bowl", "keeps_off_a_cliff"):
        pytest.mark.slow(getattr(globals()[name], f"test_{check}"))


def test_every_public_class_is_registered():
    public = {value for value in vars(stereorecal_optimistix).values() if inspect.isclass(value)}
    assert public == {point.load() for point in POINTS}
    assert len(public) == 9


@pytest.mark.parametrize("name", [point.name for point in POINTS])
def test_each_is_found_and_described_by_its_name(name):
    made, info = strategy(name), describe(name)
    assert isinstance(made, AbstractStrategy)
    assert name.replace("-", "").removeprefix("optimistix") == type(made).__name__.lower()
    assert info.distribution == "stereorecal-optimistix"
    assert info.cls is type(made)
    assert info.summary.endswith(".")
    assert len(info.summary) <= 120
