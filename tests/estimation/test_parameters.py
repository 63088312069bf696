"""θ: what each parameter moves, and that θ = 0 is the rig."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from lenses import LENSES

import stereorecal as sr
from stereorecal.estimation import rig_parameters
from stereorecal.objectives import EXTRINSICS

COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", None, None, None, "s1", "s2", "s3", "s4")
NAMES = (*EXTRINSICS, "baseline", *(f"{s}.{n}" for s in ("left", "right") for n in ("f", "aspect", "cx", "cy")))
NAMES = (*NAMES, *(f"{side}.{name}" for side in ("left", "right") for name in COEFFICIENTS if name))


def moved(rig: sr.StereoRig, name: str, change: float) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """Written out: extrinsics, camera matrices and twelve coefficients of a rig one parameter of which has changed."""
    extrinsics, length = rig.extrinsics.copy(), np.linalg.norm(rig.extrinsics[3:])
    matrices = [np.array(camera.matrix) for camera in (rig.left, rig.right)]
    lenses = [np.pad(camera.distortion, (0, 12))[:12] for camera in (rig.left, rig.right)]
    if name in ("pitch", "yaw", "roll"):
        extrinsics[("pitch", "yaw", "roll").index(name)] += np.radians(change)
    elif name in ("y", "z"):
        extrinsics[4 if name == "y" else 5] += change / 100 * length
    elif name == "baseline":
        extrinsics[3:] *= 1 + change / 100
    else:
        side, kind = name.split(".")
        matrix, lens = matrices[side == "right"], lenses[side == "right"]
        if kind in COEFFICIENTS:
            lens[COEFFICIENTS.index(kind)] += change
        elif kind in ("cx", "cy"):
            matrix[("cx", "cy").index(kind), 2] += change
        else:
            matrix[1, 1] *= np.exp(change / 100)
            matrix[0, 0] *= np.exp(change / 100 * (kind == "f"))
    return extrinsics, matrices, lenses


def test_at_zero_it_is_the_rig(rig, chart):
    here = chart.rig_at(np.zeros(chart.dim))
    np.testing.assert_array_equal(here.extrinsics, rig.extrinsics)
    assert here.left is rig.left
    assert here.right is rig.right


def test_what_drifts_comes_first(chart):
    assert chart.names[:5] == EXTRINSICS
    assert sorted(chart.names) == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_parameter_moves_what_it_says_and_nothing_else(rig, chart, name):
    here, change = chart.names.index(name), 1e-3 if name.split(".")[-1] in COEFFICIENTS else 1.0
    found = chart.rig_at(change * np.eye(chart.dim)[here])
    extrinsics, matrices, lenses = moved(rig, name, change)
    np.testing.assert_allclose(found.extrinsics, extrinsics, atol=1e-15)
    for camera, matrix, lens in zip((found.left, found.right), matrices, lenses, strict=True):
        np.testing.assert_allclose(camera.matrix, matrix, rtol=1e-15)
        np.testing.assert_allclose(np.pad(camera.distortion, (0, 12))[:12], lens, atol=1e-15)


@settings(max_examples=15)
@given(coefficients=st.sampled_from(sorted(LENSES)), seed=st.integers(0, 999))
def test_a_rig_lies_where_it_was_made(rig, coefficients, seed):
    cameras = (sr.Camera((640, 480), rig.left.matrix, np.array(LENSES[coefficients])), rig.right)
    chart = rig_parameters(sr.StereoRig(*cameras, rig.extrinsics))
    sizes = [1e-3 if parameter.unit == "" else 2.0 for parameter in chart.parameters]
    theta = np.random.default_rng(seed).uniform(-1, 1, chart.dim) * sizes
    np.testing.assert_allclose(chart.coordinates_of(chart.rig_at(theta)), theta, atol=1e-9)
