"""Parameters with names and priors, and the box that they span: rigs, rows and their derivatives."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import stereorecal as sr
from stereorecal.geometry import changed_camera, distort, ray_slopes, reread
from stereorecal.geometry.projections import NAMES as PROJECTIONS
from stereorecal.objectives import SIDES, Parameters, Reach, as_parameters, differences_at, linearised, row_chart
from stereorecal.scoring import Correspondences, with_rays_of

RIG = sr.synthetic.default_rig()
EXTRINSICS, INTRINSICS = (as_parameters(group).names for group in ("extrinsics", "intrinsics"))
MORE = ("aspect", "p1", "p2", "k3", "s1", "s2", "s3", "s4")  # of radial-tangential lenses
ALL = Parameters((*EXTRINSICS, "baseline", *INTRINSICS, *(f"{side}.{name}" for side in SIDES for name in MORE)))
CHART = row_chart(RIG, Reach(), ALL)
in_box = st.tuples(*[st.floats(-0.3, 0.3)] * len(ALL.names)).map(np.array)


def seen(rig: sr.StereoRig, seed: int = 0, points: int = 60) -> Correspondences:
    """Exact correspondences of random points."""
    rng = np.random.default_rng(seed)
    left = RIG.left.rays(rng.uniform([30, 30], [610, 450], (2, points, 2)))
    right = left * rng.uniform(3, 30, (2, points, 1)) @ rig.rotation.T + rig.translation
    right = right / right[..., 2:]
    fill = (np.ones((2, points)), np.zeros((2, points), np.int32))
    return Correspondences(left, right, *fill, *(np.asarray(n, np.float32) for n in (600.0, 1.0, 0.2)))


def test_names_and_groups():
    assert Parameters().names == ("pitch", "yaw", "roll", "y", "z")
    assert as_parameters("rotation").names == ("pitch", "yaw", "roll")
    both = as_parameters(("intrinsics", "extrinsics", "yaw"))
    assert both.names == (*EXTRINSICS, *INTRINSICS)
    assert both.axes == EXTRINSICS
    assert both.shared == INTRINSICS
    assert as_parameters(None).shared == ()
    assert as_parameters(both) is both


@pytest.mark.parametrize(
    ("free", "said"),
    [(("pich",), "did you mean pitch"), ((), "nothing is free"), (3, "give names or groups"), (("left.k9",), "left.k")],
)
def test_names_that_are_wrong(free, said):
    with pytest.raises(sr.InputError, match=said):
        as_parameters(free)


@pytest.mark.parametrize("priors", [{"left.f": 0.0}, {"yaw": float("nan")}, {"f": 1.0}])
def test_priors_that_are_wrong(priors):
    with pytest.raises(sr.InputError):
        Parameters(priors=priors)


def test_units_are_those_of_people():
    """A prior of one standard deviation is a sixth of the box, in degrees, percent and pixels."""
    by_name = dict(zip(CHART.names, CHART.units * CHART.prior, strict=True))
    assert by_name["yaw"] == pytest.approx(1.0)
    assert by_name["y"] == pytest.approx(1.0)
    assert by_name["left.f"] == pytest.approx(0.5)
    assert by_name["right.cx"] == pytest.approx(2.0)
    wide = replace(RIG, left=RIG.left.resized((1280, 960)), right=RIG.right.resized((1280, 960)))
    assert Parameters(("left.cx",)).of(wide, Reach())[0].sigma == pytest.approx(4.0)
    assert Parameters(("left.cx",), {"left.cx": 0.7}).of(wide, Reach())[0].sigma == 0.7


@settings(max_examples=20)
@given(z=in_box)
def test_the_rig_at_a_point(z):
    rig = CHART.rig_at(z)
    change = dict(zip(CHART.names, CHART.units * z, strict=True))
    np.testing.assert_allclose(
        np.degrees(rig.extrinsics[:3] - RIG.extrinsics[:3]), [change[n] for n in ("pitch", "yaw", "roll")], atol=1e-9
    )
    assert rig.extrinsics[3] == pytest.approx(RIG.extrinsics[3] * (1.0 + change["baseline"] / 100))
    assert rig.left.matrix[0, 0] == pytest.approx(RIG.left.matrix[0, 0] * np.exp(change["left.f"] / 100))
    assert rig.right.matrix[1, 2] == pytest.approx(RIG.right.matrix[1, 2] + change["right.cy"])
    assert rig.left.distortion[1] == pytest.approx(RIG.left.distortion[1] + change["left.k2"])
    back = CHART.coordinates(rig.extrinsics)
    np.testing.assert_allclose(back[:6], z[:6], atol=1e-9)
    assert not back[6:].any()
    assert CHART.rig_at(0 * z).left is RIG.left


@settings(max_examples=max(4, settings.default.max_examples // 5))
@given(z=in_box, by=in_box, seed=st.integers(0, 5), projection=st.sampled_from(PROJECTIONS))
def test_derivatives_of_the_rows(z, by, seed, projection):
    """Central differences along any direction of the box, intrinsics included, in views of all projections."""
    found, step = replace(seen(RIG, seed), projection=projection), 1e-4 * by
    rows, slopes = (600.0 * part for part in linearised((found.left, found.right), projection, CHART, z))
    np.testing.assert_allclose(rows, differences_at(found, CHART, z), atol=1e-9)
    ends = [differences_at(found, CHART, z + step), differences_at(found, CHART, z - step)]
    np.testing.assert_allclose(np.tensordot(step, slopes, 1), (ends[0] - ends[1]) / 2, atol=1e-7)


@settings(max_examples=20)
@given(z=in_box)
def test_pixels_read_by_another_camera(z):
    """Rays go back to pixels and on to rays, as OpenCV's undistortPoints has it."""
    other = CHART.rig_at(z)
    found = seen(RIG)
    pixels = RIG.left.project(found.left)
    ours = with_rays_of(other, found, matched_rig=RIG).left
    criteria = (cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, 200, 1e-14)
    lens = other.left.matrix, other.left.distortion
    theirs = cv2.undistortPoints(pixels.reshape(-1, 1, 2), *lens, criteria=criteria)
    np.testing.assert_allclose(ours[..., :2].reshape(-1, 2), theirs.reshape(-1, 2), atol=1e-8)
    np.testing.assert_allclose(reread(ours, other.left, RIG.left), found.left, atol=1e-10)


@pytest.mark.parametrize("coefficients", [0, 4, 5, 8, 12, 14])
def test_every_lens_model_can_change(coefficients):
    distortion = np.zeros(coefficients)
    distortion[:2] = [-0.2, 0.05][: min(2, coefficients)]
    camera = sr.Camera((640, 480), RIG.left.matrix, distortion)
    rays = camera.rays(np.array([[50.0, 40.0], [320.0, 240.0], [600.0, 300.0]]))
    names = ("f", "cx", "k1", "k3", "aspect")
    slopes, pixels = ray_slopes(camera, rays, names), camera.project(rays)
    for slope, name in zip(slopes, names, strict=True):
        ends = [changed_camera(camera, {name: h}).rays(pixels)[:, :2] for h in (1e-5, -1e-5)]
        np.testing.assert_allclose(slope, (ends[0] - ends[1]) / 2e-5, atol=1e-8)
    more = changed_camera(camera, {"k1": 0.01}).distortion
    assert more.size == max(4, coefficients)
    assert np.isfinite(distort(rays[:, :2], more)).all()


def test_where_no_rig_stands():
    chart = row_chart(RIG, Reach(3.0, 0.03), Parameters())
    assert chart.stands_at(np.zeros(chart.dim))
    assert not chart.stands_at(np.array([0.0, 0.0, 0.0, 0.0, 1e3]))
