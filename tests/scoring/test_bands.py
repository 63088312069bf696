"""A count of a part of the rows: where the rows lie, that bands add up, and that the maximum stays."""

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures import SAD_48
from hypothesis import given, strategies as st

import stereorecal as sr
from stereorecal import InputError
from stereorecal.geometry import view, with_unit_baseline
from stereorecal.objectives import Parameters, Reach, count_chart, count_objective
from stereorecal.scoring import bands, prepare, pyramid
from stereorecal.scoring.host import counts, rectify


@pytest.fixture(scope="module")
def prepared(scene):
    given_scene = scene("street", 0, (320, 240))
    return prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))


@given(share=st.floats(0.001, 1.0))
def test_bands_are_apart_inside_and_of_the_share_that_was_asked_for(prepared, share):
    parts = bands(prepared, share)
    firsts = np.array([float(prepared.view.centre_row - part.view.centre_row) for part in parts])
    height = parts[0].view.size[1]
    assert {part.view.size for part in parts} == {(320, height)}
    assert (np.diff(firsts) >= height).all()
    assert firsts[0] >= 0
    assert firsts[-1] + height <= 240
    assert abs(sum(part.pixels for part in parts) / prepared.pixels - share) <= 16 / 240 or len(parts) == 1


def test_a_band_shows_the_rows_of_the_whole(scene, prepared):
    given_scene = scene("street", 0, (320, 240))
    whole = rectify(given_scene.rig, given_scene.pairs[0], view=prepared.view)
    for part in bands(prepared, 0.4):
        first = round(float(prepared.view.centre_row - part.view.centre_row))
        band = rectify(given_scene.rig, given_scene.pairs[0], view=part.view)
        for rows, of_whole in zip(band, whole, strict=True):
            np.testing.assert_allclose(rows, of_whole[first : first + 32], atol=0.05)


def test_all_rows_are_the_view_itself(prepared):
    assert bands(prepared, 1.0) == (prepared,)


@pytest.mark.parametrize("share", [0.0, 1.01, float("nan")])
def test_shares_that_make_no_sense(scene, share):
    given_scene = scene()
    with pytest.raises(InputError, match="share of the rows"):
        sr.objective(given_scene.rig, given_scene.pairs, matcher=SAD_48, rows=share)


@pytest.mark.slow
def test_an_objective_adds_its_bands_up_and_costs_less(scene, prepared):
    given_scene = scene("street", 0, (320, 240))
    few = sr.objective(given_scene.rig, given_scene.pairs, matcher=SAD_48, rows=0.4)
    points = np.stack([np.zeros(few.dim), np.full(few.dim, 0.02)])
    expected = [
        counts(band, np.stack([with_unit_baseline(few.images.chart.extrinsics(p)) for p in points]), SAD_48)
        for band in bands(prepared, 0.4)
    ]
    found = few.batch(points)
    np.testing.assert_array_equal(found, np.sum(expected, axis=0))
    assert few.problem.cost == pytest.approx(96 / 240)
    np.testing.assert_allclose([few.traced.count(jnp.asarray(p, jnp.float32)) for p in points], found, rtol=2e-3)


@pytest.mark.parametrize("rows", [1.0, 0.4])
def test_some_rows_cost_less_where_intrinsics_are_free_too(scene, rows):
    given_scene = scene("street", 0, (320, 240))
    chart = count_chart(given_scene.rig, Reach(), Parameters(("pitch", "left.f")))
    found = count_objective(pyramid(given_scene.rig, given_scene.pairs), SAD_48, chart, rows=rows)
    assert found.cost == pytest.approx(1.0 if rows == 1.0 else 96 / 240)
