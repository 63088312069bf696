"""What is asked of a change: values that make sense, one table of them, few in number, and that they are asked."""

import ast
import re
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

import stereorecal as sr
from stereorecal import decision as rule
from stereorecal.decision import ENOUGH, LIMITS, Tolerances, Verdict, as_tolerances, decide
from stereorecal.objectives import EXTRINSICS as AXES

TABLE = Path(__file__).parents[2] / "docs" / "reference" / "decision.md"
RULE = [Path(rule.__file__).with_name(name) for name in ("_rule.py", "_checks.py")]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"harm": 0.0}, "between 0 and 1"),
        ({"good_surely": 1.0}, "between 0 and 1"),
        ({"rows_px": 0.0}, "more than 0"),
        ({"depth_points": float("nan")}, "give a number"),
        ({"good_rows_px": True}, "give a number"),
        ({"distances": ()}, "give some"),
        ({"distances": (5, 0.5)}, "in baselines, each 1 or more"),
        ({"distances": (5, float("inf"))}, "in baselines, each 1 or more"),
        ({"hram": 0.1}, "did you mean harm"),
    ],
)
def test_nonsense_is_one_sentence(wrong, said):
    with pytest.raises(sr.InputError, match=said) as error:
        as_tolerances(wrong)
    assert "\n" not in str(error.value)


@given(harm=st.floats(1e-4, 0.5), distances=st.lists(st.integers(1, 200), min_size=1, max_size=5))
def test_values_by_name_are_those_of_the_class(harm, distances):
    named = as_tolerances({"harm": harm, "distances": tuple(distances)})
    assert named == Tolerances(harm=harm, distances=tuple(distances))
    assert named.distances == tuple(sorted(set(distances)))
    assert as_tolerances(named) is named
    assert as_tolerances({}) == Tolerances() == as_tolerances(None)


def test_one_table_has_all_of_them():
    rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]+?) \|", TABLE.read_text(encoding="utf-8"), re.MULTILINE))
    distances = rows.pop("distances")
    assert {name: float(value) for name, value in rows.items()} == LIMITS
    assert tuple(map(float, distances.split(","))) == Tolerances().distances


def numbers_of(module: Path) -> list[str]:
    """Those that decide: indices and shapes do not."""
    tree = ast.parse(module.read_text(encoding="utf-8"))
    layout = [node.slice for node in ast.walk(tree) if isinstance(node, ast.Subscript)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "reshape":
            layout += node.args
    spared = {id(part) for node in layout for part in ast.walk(node)}
    return [
        f"{module.name}:{node.lineno}: {node.value}"
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float | complex)
        if id(node) not in spared and node.value not in (0, 1)
    ]


def test_the_rule_is_short_and_has_no_numbers_but_those_of_two_tables():
    """At most ten each; what a reader has to believe is there, with its reason."""
    assert [number for module in RULE for number in numbers_of(module)] == []
    assert len(fields(Tolerances)) <= 10
    assert len(asdict(ENOUGH)) <= 10
    assert sum(len(module.read_text(encoding="utf-8").splitlines()) for module in RULE) <= 365


def test_who_asks_for_more_gets_fewer_repairs(drifted, hardly):
    several = [seen for _, seen in [drifted[0], *hardly[2:]]]

    def repaired(**asked) -> set[int]:
        limits = Tolerances(**asked)
        return {at for at, seen in enumerate(several) if decide(seen, AXES, limits).verdict is Verdict.REPAIR}

    usual = repaired()
    assert usual
    for more in ({"leaves": 0.15}, {"predicts": 0.15}, {"harm": 1e-6, "depth_points": 0.01}, {"rows_px": 2.0}):
        assert repaired(**more) < usual


def test_depth_counts_at_the_farthest_distance(drifted):
    near, far = ([decide(seen, AXES, Tolerances(distances=of)) for _, seen in drifted[:2]] for of in ((3,), (3, 300)))
    assert np.mean([one.loss[1] for one in near]) < np.mean([one.loss[1] for one in far])
