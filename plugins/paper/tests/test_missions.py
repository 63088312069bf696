"""The mission log: the paper's shape, drift and chessboard errors of the right size, the same again from a seed."""

import numpy as np
import pytest
from stereorecal_paper import plan_missions

from stereorecal.synthetic import default_rig


@pytest.fixture(scope="module")
def plans():
    return [plan_missions(seed) for seed in range(30)]


def degrees_and_shares(differences, baseline):
    return np.degrees(np.abs(differences[..., :3])), np.abs(differences[..., 3:]) / baseline


def test_the_shape_of_the_paper():
    plan = plan_missions(0)
    assert len(plan.calibrations) == 11
    dates = list(plan.calibrations)
    assert dates == sorted(dates)
    assert int(dates[-1][:4]) - int(dates[0][:4]) == 7
    assert [planned.mission.name[-3:].strip("e") for planned in plan.missions] == [
        "60",
        "65",
        "67",
        "71",
        "90",
        "103",
        "104",
    ]
    assert sum(len(planned.kinds) for planned in plan.missions) == 60
    for planned in plan.missions:
        assert planned.mission.calibration == max(d for d in dates if d < planned.mission.name)
        kinds = {f"{image:03d}.png": kind for image, kind in enumerate(planned.kinds, 1)}
        assert planned.mission.starred == {name for name, kind in kinds.items() if kind == "open-sea"}
    assert {kind for planned in plan.missions for kind in planned.kinds} == {"harbour", "coast", "open-sea"}


def test_states_differ_by_up_to_two_and_a_half_degrees_and_eight_millimetres(plans):
    truths = np.array([[p.mission.truth.extrinsics for p in plan.missions] for plan in plans])
    differences = truths[:, :, None] - truths[:, None]
    angles, lengths = np.degrees(np.abs(differences[..., :3])), np.abs(differences[..., 3:])
    assert angles.max() <= 2.5 + 1e-9
    assert lengths[..., 1:].max() <= 0.008 + 1e-12
    assert angles.max(axis=(0, 1, 2)).min() > 2.0
    assert lengths[..., 1:].max(axis=(0, 1, 2)).min() > 0.006
    assert lengths[..., 0].max() < 1e-12  # the baseline itself does not drift


def test_a_manual_calibration_carries_the_error_of_a_chessboard(plans):
    errors = np.array(
        [
            plan.calibrations[p.mission.calibration].extrinsics - p.mission.truth.extrinsics
            for plan in plans
            for p in plan.missions
        ]
    )
    angles, shares = degrees_and_shares(errors, default_rig().baseline)
    np.testing.assert_allclose(np.sqrt(np.mean(angles**2, axis=0)), 0.03, rtol=0.25)
    np.testing.assert_allclose(np.sqrt(np.mean(shares**2, axis=0)), 0.001, rtol=0.25)


def test_the_same_seed_gives_the_same_plan():
    one, two, other = plan_missions(3), plan_missions(3), plan_missions(4)
    for name, rig in one.calibrations.items():
        np.testing.assert_array_equal(rig.extrinsics, two.calibrations[name].extrinsics)
        assert np.abs(rig.extrinsics - other.calibrations[name].extrinsics).max() > 0
    assert [p.seeds for p in one.missions] == [p.seeds for p in two.missions] != [p.seeds for p in other.missions]


def test_fewer_pairs_are_the_first_of_all():
    few, all_of_them = plan_missions(0, most_pairs=2), plan_missions(0)
    for short, long in zip(few.missions, all_of_them.missions, strict=True):
        assert (short.kinds, short.seeds) == (long.kinds[:2], long.seeds[:2])
        np.testing.assert_array_equal(short.mission.truth.extrinsics, long.mission.truth.extrinsics)


def test_pairs_are_taken_by_the_rig_as_it_was():
    planned = plan_missions(0, rig=default_rig().resized((160, 120)), most_pairs=2).missions[1]
    mission = planned.photographed()
    assert [pair.name for pair in mission.pairs] == ["001.png", "002.png"]
    assert mission.pairs[0].size == (160, 120)
    assert mission.starred == {"002.png"}
    sea, shore = (np.mean(np.abs(np.diff(pair.left, axis=0))) for pair in reversed(mission.pairs))
    assert sea < 0.5 * shore
    again = planned.photographed()
    np.testing.assert_array_equal(again.pairs[0].right, mission.pairs[0].right)
    with pytest.raises(AssertionError):
        np.testing.assert_array_equal(mission.pairs[0].left, mission.pairs[1].left)
