"""Steps of θ where a lens may fold its image back."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from lenses import WIDE_LENSES
from parts_of_estimates import within_field

import stereorecal as sr
from stereorecal.estimation import rig_parameters
from stereorecal.scoring import Correspondences, with_rays_of

FOCAL = {"omni": 600.0}  # pixels, of a plane behind a sphere; the others 280


def chart_of(model: str):
    focal = FOCAL.get(model, 280.0)
    matrix = np.array([[focal, 0, 320], [0, focal, 240], [0, 0, 1]])
    camera = sr.Camera((640, 480), matrix, np.array(WIDE_LENSES.get(model, [-0.1, 0.01, 0, 0])), model=model)
    return rig_parameters(sr.StereoRig(camera, camera, np.array([0, 0, 0, -0.1, 0, 0])))


def found_of(chart) -> Correspondences:
    pixels = np.stack(np.meshgrid(np.linspace(40, 600, 9), np.linspace(30, 450, 7)), -1).reshape(1, -1, 2)
    rays, ones = np.asarray(chart.rig.left.rays(pixels)), np.ones((1, pixels.shape[1]))
    return Correspondences(rays, rays, ones, ones.astype(int), *(np.array(value) for value in (280.0, 1.0, 1.0)))


@pytest.mark.parametrize("model", sorted(WIDE_LENSES))
@settings(max_examples=25)
@given(seed=st.integers(0, 999), far=st.floats(0.01, 3.0))
def test_every_step_ends_where_all_that_was_found_has_rays(model: str, seed: int, far: float):
    chart = chart_of(model)
    found, terms = found_of(chart), [parameter.unit == "" for parameter in chart.parameters]
    move = far * np.where(terms, 1.0, 0.01) * np.random.default_rng(seed).uniform(-1, 1, chart.dim)
    taken = within_field(found, chart, np.zeros(chart.dim), move)
    read = with_rays_of(chart.rig_at(taken), found, matched_rig=chart.rig)
    assert np.isfinite(read.left).all()
    assert np.isfinite(read.right).all()
    shares = taken / np.where(move == 0.0, 1.0, move)
    np.testing.assert_allclose(shares, shares[0], atol=1e-12)  # shorter, in the same direction
    assert 0.0 < shares[0] <= 1.0


def test_steps_are_shortened_only_where_a_lens_ends():
    chart = chart_of("equidistant")
    fold = np.where([name == "left.k4" for name in chart.names], -0.5, 0.0)
    small = 1e-3 * fold
    found, here = found_of(chart), np.zeros(chart.dim)
    assert np.abs(within_field(found, chart, here, fold)).max() < 0.5
    np.testing.assert_array_equal(within_field(found, chart, here, small), small)
    pinhole = chart_of("radtan")
    far = np.full(pinhole.dim, 0.5)
    assert within_field(found_of(pinhole), pinhole, np.zeros(pinhole.dim), far) is far
