"""Stages and schedules: what they refuse, at which scale they look, whose strategy they take."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from moody import Crashing

import stereorecal as sr
from stereorecal import InputError
from stereorecal.recalibration import Schedule, Stage, as_settings
from stereorecal.strategies import Need, strategy

COMPASS = strategy("compass")


class Solver(Crashing):
    needs = Need.RESIDUALS


class Climber(Solver):
    needs = Need.SMOOTH


class Detector(Solver):
    needs = Need.IMAGES


@pytest.mark.parametrize("scale", [0.0, -0.5, 1.001, np.nan, np.inf])
def test_a_scale_that_makes_no_sense(scale):
    with pytest.raises(InputError, match=r"scale .*makes no sense"):
        Schedule.count(COMPASS, scale)


sizes = st.tuples(st.integers(16, 8000), st.integers(16, 8000))
limits = st.tuples(st.integers(1, 10**7), st.integers(1, 10**7)).map(lambda pair: (min(pair), max(pair)))
scales = st.floats(0.01, 1.0)


@given(scales, limits, sizes)
def test_the_scale_bends_no_more_than_it_must(scale, pixels, size):
    stage = Stage(COMPASS, scale, pixels=pixels)
    found, area = stage.scale_for(size), size[0] * size[1]
    assert 0 < found <= 1
    assert found**2 * area <= pixels[1] * (1 + 1e-9)
    assert found**2 * area >= min(pixels[0], area) * (1 - 1e-9)  # images are never enlarged
    if pixels[0] <= scale**2 * area <= pixels[1]:
        assert found == pytest.approx(scale)


@pytest.mark.parametrize(
    ("size", "expected"),
    [((640, 480), (0.25, 0.5, 1.0)), ((320, 240), (0.456, 0.884, 1.0)), ((1920, 1080), (0.12, 0.241, 0.481))],
)
def test_scales_of_the_default_schedule(size, expected):
    assert [s.scale_for(size) for s in Schedule.default().stages] == pytest.approx(expected, abs=2e-3)
    assert Schedule.default().strategies == ("compass",)


def test_default_without_its_plugins(nothing_installed):
    """One sentence that says what to install."""
    with pytest.raises(InputError, match="strategy compass is not installed; run: pip install"):
        Schedule.default()
    with pytest.raises(InputError, match="strategy compass is not installed"):
        as_settings({})
    assert as_settings({}, sr.HealthOptions.__optional_keys__).schedule.strategies == ()  # a look needs none


@pytest.mark.parametrize(
    ("made", "replaced"),
    [(Solver(), [1, 2]), (Climber(), [0]), (Detector(), [0]), (strategy("compass", step=0.5), [0])],
)
def test_using_a_strategy_where_it_fits(made, replaced):
    before, after = Schedule.default(), Schedule.default().using(made)
    for index, (old, new) in enumerate(zip(before.stages, after.stages, strict=True)):
        assert new.strategy is made if index in replaced else new == old
        assert (new.scale, new.score, new.rounds, new.pixels) == (old.scale, old.score, old.rounds, old.pixels)
    assert after.name == before.name
    assert before == Schedule.default()


def test_all_frames_are_decided_on_however_few_the_last_stage_looks_at(scene):
    given, schedule = scene(frames=3), Schedule.default()
    off = given.rig.with_extrinsics(given.rig.extrinsics + np.radians([1.4, 0.0, -1.4, 0.0, 0.0, 0.0]))
    few = replace(schedule, stages=(*schedule.stages[:-1], replace(schedule.stages[-1], frames=2)))
    repaired = sr.recalibrate(off, given.pairs, matcher=sr.SAD(num_disparities=24), schedule=few)
    assert repaired.accepted
    assert repaired.used == (0, 1, 2)
    assert len(repaired.found.weight) == 3


def test_a_budget_that_ends_after_a_stage_on_fewer_frames(scene):
    given = scene(frames=3)  # without a survey, whose start a look would settle from
    options = {"matcher": sr.SAD(num_disparities=24), "schedule": replace(Schedule.default(), survey=False)}
    off = given.rig.with_extrinsics(given.rig.extrinsics + np.radians([2.2, 0.0, -2.2, 0.0, 0.0, 0.0]))
    climbed, *_ = sr.recalibrate(off, given.pairs, **options).stages
    cut = sr.recalibrate(off, given.pairs, budget=climbed.cost.budgeted + 2.5, **options)
    assert cut.reason is sr.recalibration.Reason.OUT_OF_BUDGET
    assert len(cut.found.weight) == 2
