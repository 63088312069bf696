"""What to show next: what narrows most an interval that is too wide, by the filter's own covariance."""

from pathlib import Path

import numpy as np
import pytest
from parts_of_estimates import Measurement
from parts_of_repairs import _advice
from rides import BEFORE

from stereorecal.estimation import Normal
from stereorecal.io import load_scene
from stereorecal.matching import matcher
from stereorecal.online import BAND_EDGES, PARTS, Config, Kind, State, Stepped, advice, init, step
from stereorecal.recalibration import DISTANCES
from stereorecal.synthetic import default_rig

EVERYWHERE = np.ones((PARTS[0] * PARTS[1], len(DISTANCES)), int)


def bent(config: Config = Config()) -> State:  # noqa: B008  frozen
    """Rows are known everywhere, and depth is not: they are bent as by 1.5 degrees of yaw, and so the calibration was a
    bad one."""
    state = init(default_rig(), config)
    estimate, shown = state.estimate, 1.5 * np.eye(len(state.theta))[1]
    for one in _advice._looks(state, *_advice._near(state)):
        a = 10.0 * one.measures.normal.a
        estimate = estimate.updated(Measurement(Normal(a, a @ shown, 0.0), np.zeros(3)))
    return state.replace(estimate=estimate, coverage=EVERYWHERE, seen=9)


def test_a_rig_of_which_nothing_is_known_is_shown_something():
    found = advice(init(default_rig()))
    assert found.show is not None
    assert found.show.part is not None
    assert not found.show.motion
    assert found.show.narrows == found.undetermined[0]
    assert {"pitch", "roll", "y", "z"} <= set(found.axes)
    excess = [one.half_width / one.matters for one in found.undetermined]
    assert excess == sorted(excess, reverse=True)
    assert excess[-1] > 1.0
    assert not found.stands


def test_what_was_shown_is_known():
    """Followed again and again, the advice ends: it never asks for what would tell nothing."""
    state, shown = init(default_rig(), Config(prior="exact", motion=False)), []
    while (found := advice(state)).undetermined:
        assert found.show is not None
        asked = (found.show.part, found.show.distance)
        shown.append(asked)
        assert len(shown) < 9
        (seen,) = [one for one in _advice._looks(state, *_advice._near(state)) if (one.part, one.distance) == asked]
        state = state.replace(estimate=state.estimate.updated(seen.measures))
        after = {(one.error, one.distance): one.half_width for one in advice(state).undetermined}
        narrowed = found.show.narrows
        assert after.get((narrowed.error, narrowed.distance), 0.0) <= found.show.half_width * (1 + 1e-9)
    assert len(set(shown)) > 1


def test_depth_that_rows_do_not_tell_needs_motion():
    found = advice(bent())
    assert found.undetermined[0].error == "depth"
    assert found.show is not None
    assert (found.show.motion, found.show.part, found.show.distance) == (True, None, None)
    assert found.show.half_width < found.undetermined[0].half_width / 2.0
    assert "yaw" in found.axes


def test_of_a_rig_that_is_not_followed_nothing_tells_depth():
    found = advice(bent(Config(motion=False)))
    assert found.undetermined
    assert found.show is None


def test_from_afar_motion_tells_nothing_until_something_is_near():
    far = np.where(np.array(DISTANCES) == DISTANCES[-1], EVERYWHERE, 0)
    found = advice(bent().replace(coverage=far))
    assert found.show is not None
    assert found.show.motion
    assert found.show.distance in (5.0, 10.0, 30.0)


def test_what_the_matcher_does_not_seek_is_not_asked_for():
    state = init(default_rig())
    near = state.view.focal / BAND_EDGES[0]
    distances = {one.distance for one in advice(state).undetermined}
    limited = state.replace(matcher=matcher("sad", num_disparities=16 * int(near // 16)))
    fewer = {one.distance for one in advice(limited).undetermined}
    assert distances - fewer == {5.0}


def test_a_dark_pair():
    assert advice(init(default_rig()).replace(reported=Kind.TOO_LITTLE_TEXTURE)).blind


def test_the_answer_stands(ridden: list[Stepped]):
    """Before the knock; not while pairs hardly match, or a repair is due."""
    stands = [advice(stepped.state).stands for stepped in ridden]
    assert stands[BEFORE - 1]
    assert not any(stands[BEFORE : BEFORE + 2])


def test_the_sea_is_near_below_and_far_above(ridden: list[Stepped]):
    coverage = ridden[BEFORE - 1].state.coverage.reshape(*PARTS, -1)
    assert coverage.max() <= BEFORE
    nearest = [int(np.flatnonzero(row.sum(axis=0))[0]) for row in coverage]
    assert nearest[0] > nearest[2]
    assert coverage[2].sum(axis=1).all()


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("first", ["garden01", "sundial01", "chair01"])
def test_on_real_images_what_is_advised_narrows_most(data_dir: Path, first: str):
    """One of four scenes of a rig shows something as near as is asked for: it narrows the interval most."""
    folder = data_dir / "boofcv_bumblebee2"
    pairs = {name: load_scene(folder / name).pairs[0] for name in ("garden01", "stones01", "sundial01", "chair01")}
    rig, config = load_scene(folder / first).rig, Config(motion=False, repair=False)
    assert rig is not None
    state, _ = step(init(rig, config), pairs[first])
    show = advice(state).show
    assert show is not None
    assert (show.narrows.error, show.distance) == ("epipolar", 5.0)
    left = {
        name: next(one.half_width for one in advice(step(state, pair)[0]).undetermined if one.distance == 5.0)
        for name, pair in pairs.items()
    }
    assert min(left, key=lambda name: left[name]) == "stones01"
    assert left["stones01"] == pytest.approx(show.half_width, rel=0.25)
    assert left["stones01"] < 0.75 * show.narrows.half_width
