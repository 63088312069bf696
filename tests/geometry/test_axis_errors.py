"""The error of each axis, which tables, JSON files and reports share."""

import numpy as np
from hypothesis import given, strategies as st

from stereorecal.geometry import axis_errors
from stereorecal.synthetic import default_rig

RIG = default_rig()
B = float(RIG.baseline)
angles = st.tuples(*[st.floats(-0.3, 0.3)] * 3)
shifts = st.tuples(*[st.floats(-0.3, 0.3)] * 2)  # of y and z, in baselines
rigs = st.builds(lambda turn, shift: RIG.with_extrinsics(np.array([*turn, -B, *(B * np.array(shift))])), angles, shifts)
factors = st.floats(1e-3, 1e4)


def in_unit(rig, factor):
    return rig.with_extrinsics(np.concatenate([rig.extrinsics[:3], factor * rig.extrinsics[3:]]))


def numbers(errors) -> np.ndarray:
    return np.array([*errors.values()])


def test_names_units_and_signs():
    """Pitch 1° too large, roll half a degree too small, y a hundredth of the baseline off."""
    step = np.array([np.radians(1.0), 0, -np.radians(0.5), 0, 0.01 * B, 0])
    errors = axis_errors(RIG.with_extrinsics(RIG.extrinsics + step), RIG)
    assert list(errors) == ["pitch", "yaw", "roll", "x", "y", "z"]
    assert all(type(v) is float for v in errors.values())
    rotation, shift = numbers(errors)[:3], numbers(errors)[4:]
    np.testing.assert_allclose(rotation, [1.0, 0.0, 0.5], atol=1e-9)
    np.testing.assert_allclose(shift, [1.0, 0.0], atol=1e-3)


@given(first=rigs, second=rigs, third=rigs)
def test_errors_are_distances(first, second, third):
    """None from itself, never negative, the same both ways, and a detour is no shorter."""
    np.testing.assert_array_equal(numbers(axis_errors(first, first)), 0.0)
    there, back = numbers(axis_errors(first, second)), numbers(axis_errors(second, first))
    assert (there >= 0).all()
    np.testing.assert_array_equal(there, back)
    detour = numbers(axis_errors(first, third)) + numbers(axis_errors(third, second))
    assert (there <= detour + 1e-9).all()


@given(rig=rigs, reference=rigs, unit=factors, longer=factors)
def test_neither_the_unit_nor_the_length_of_the_baseline_matters(rig, reference, unit, longer):
    """Images do not show the length: a rig in millimetres, or one that is twice as wide, has the same errors."""
    expected = numbers(axis_errors(rig, reference))
    for first, second in ((unit, unit), (1.0, longer), (longer, 1.0)):
        errors = axis_errors(in_unit(rig, first), in_unit(reference, second))
        np.testing.assert_allclose(numbers(errors), expected, rtol=1e-9, atol=1e-9)


@given(rig=rigs, turn=angles)
def test_a_turn_is_seen_on_its_own_axes_only(rig, turn):
    moved = rig.with_extrinsics(rig.extrinsics + np.array([*turn, 0, 0, 0]))
    errors = numbers(axis_errors(moved, rig))
    np.testing.assert_allclose(errors[:3], np.abs(np.degrees(turn)), atol=1e-9)
    assert errors[3:].tolist() == [0.0, 0.0, 0.0]
