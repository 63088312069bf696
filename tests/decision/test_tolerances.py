"""What is asked of a change: values that make sense, one table of them, and that they are asked."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

import stereorecal as sr
from stereorecal.decision import LIMITS, Tolerances, Verdict, as_tolerances, decide
from stereorecal.estimation import estimate

AXES = ("pitch", "yaw", "roll", "y", "z")
TABLE = Path(__file__).parents[2] / "docs" / "reference" / "decision.md"


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"alpha": 0.0}, "between 0 and 1"),
        ({"good_surely": 1.0}, "between 0 and 1"),
        ({"gain_px": -0.1}, "0 or more"),
        ({"gain_px": float("nan")}, "give a number"),
        ({"blind_rows_px": True}, "give a number"),
        ({"distances": ()}, "give some"),
        ({"distances": (5, 0.5)}, "in baselines, each 1 or more"),
        ({"distances": (5, float("inf"))}, "in baselines, each 1 or more"),
        ({"alhpa": 0.1}, "did you mean alpha"),
    ],
)
def test_nonsense_is_one_sentence(wrong, said):
    with pytest.raises(sr.InputError, match=said) as error:
        as_tolerances(wrong)
    assert "\n" not in str(error.value)


@given(alpha=st.floats(1e-4, 0.5), distances=st.lists(st.integers(1, 200), min_size=1, max_size=5))
def test_values_by_name_are_those_of_the_class(alpha, distances):
    named = as_tolerances({"alpha": alpha, "distances": tuple(distances)})
    assert named == Tolerances(alpha=alpha, distances=tuple(distances))
    assert named.distances == tuple(sorted(set(distances)))
    assert as_tolerances(named) is named
    assert as_tolerances({}) == Tolerances() == as_tolerances(None)


def test_one_table_has_all_of_them():
    rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]+?) \|", TABLE.read_text(encoding="utf-8"), re.MULTILINE))
    distances = rows.pop("distances")
    assert {name: float(value) for name, value in rows.items()} == LIMITS
    assert tuple(map(float, distances.split(","))) == Tolerances().distances


@pytest.fixture(scope="module")
def drifted(rig, chart, prior, seen):
    """Estimates of rigs that drifted a little: some are repaired, some are not."""

    def make(seed: int):
        rng = np.random.default_rng(seed)
        drift = np.r_[rng.uniform(-0.08, 0.08, 5), np.zeros(chart.dim - 5)]
        true = chart.rig_at(prior.roots[len(prior.roots) // 2] @ rng.normal(0, 1, chart.dim) + drift)
        return estimate(seen(rig, true, seed, cells=500), rig)

    return [make(seed) for seed in range(6)]


def test_who_asks_for_more_gets_fewer_repairs(drifted):
    def repaired(**asked) -> set[int]:
        limits = Tolerances(**asked)
        return {at for at, seen in enumerate(drifted) if decide(seen, AXES, limits).verdict is Verdict.REPAIR}

    for less, more in (
        ({"alpha": 0.2}, {"alpha": 0.001}),
        ({"gain_px": 0.0}, {"gain_px": 2.0}),
        ({"worse_depth_points": 100.0, "worse_rows_px": 1.0}, {"worse_depth_points": 0.01, "worse_rows_px": 0.0}),
    ):
        assert repaired(**more) <= repaired(**less)
    assert not repaired(gain_px=100.0)
    assert repaired(alpha=0.2)


def test_depth_counts_at_the_farthest_distance(drifted):
    near, far = (
        [decide(seen, AXES, Tolerances(distances=distances)) for seen in drifted] for distances in ((3,), (3, 300))
    )
    assert np.mean([one.loss for one in near]) < np.mean([one.loss for one in far])
    assert all(said.tolerances.distances == (3.0,) for said in near)
