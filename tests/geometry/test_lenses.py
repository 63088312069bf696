"""Lens models: round trips over all that they show, OpenCV's fisheye as the oracle, derivatives against differences."""

import cv2
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from lenses import WIDE_LENSES

from stereorecal import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, camera_changes, changed_camera, intrinsic, pixel_slopes, ray_slopes, reread

SIZE = (640, 480)
MATRIX = np.array([[280.0, 0, 322.4], [0, 283.0, 236.1], [0, 0, 1]])
WIDE = sorted(WIDE_LENSES)


def camera(model: str, coefficients=None) -> Camera:
    return Camera(SIZE, MATRIX, np.array(WIDE_LENSES[model] if coefficients is None else coefficients), model=model)


def fan(farthest: float, count: int = 400, seed: int = 0) -> np.ndarray:
    """Unit vectors up to an angle off the axis, (n, 3), with the axis itself."""
    draw = np.random.default_rng(seed)
    off, around = farthest * draw.uniform(0, 1, count), draw.uniform(0, 2 * np.pi, count)
    off[0] = 0.0
    return np.stack([np.sin(off) * np.cos(around), np.sin(off) * np.sin(around), np.cos(off)], axis=-1)


def lenses_of(model: str):
    if model == "equidistant":
        return st.tuples(*(st.floats(-size, size) for size in (0.1, 0.05, 0.02, 0.005)))
    if model == "ds":
        return st.tuples(st.floats(-0.6, 0.9), st.floats(0.0, 1.0))
    if model == "omni":
        return st.tuples(st.floats(0.0, 2.5), st.floats(-0.2, 0.1), *(st.floats(-s, s) for s in (0.03, 1e-3, 1e-3)))
    return st.tuples(st.floats(0.0, 1.0), st.floats(0.3, 3.0))


@pytest.mark.parametrize("model", WIDE)
@given(data=st.data(), length=st.floats(0.01, 100.0))
def test_there_and_back_over_the_whole_field(model: str, data, length: float):
    lens = camera(model, data.draw(lenses_of(model)))
    field = lens.lens.field(lens.distortion)
    directions = fan(0.98 * field if field < 3.0 else 2.9)
    pixels = lens.project(length * directions)
    back = lens.directions(pixels)
    angle = np.linalg.norm(np.cross(back, directions), axis=-1)
    assert np.sum(back * directions, axis=-1).min() > 0.9
    # Pixels are rounded to 1e-13 or so: where the image hardly grows any more with the angle, that is many angles.
    steps = np.linalg.norm(lens.project(fan_towards(directions, 1e-6)) - pixels, axis=-1) / 1e-6 / MATRIX[0, 0]
    assert (angle * np.minimum(steps, 1.0)).max() < 1e-9
    np.testing.assert_allclose(lens.project(back), pixels, atol=1e-9, rtol=1e-11)


def fan_towards(directions: np.ndarray, by: float) -> np.ndarray:
    """Directions that lie so much farther off the axis."""
    aside = np.hypot(directions[:, 0], directions[:, 1])
    off, around = np.arctan2(aside, directions[:, 2]) + by, np.arctan2(directions[:, 1], directions[:, 0])
    return np.stack([np.sin(off) * np.cos(around), np.sin(off) * np.sin(around), np.cos(off)], axis=-1)


@given(coefficients=lenses_of("equidistant"))
def test_equidistant_is_opencvs_fisheye(coefficients):
    lens, D = camera("equidistant", coefficients), np.array(coefficients)
    directions = fan(min(0.95 * lens.lens.field(D), np.radians(85.0)))
    points = directions / directions[:, 2:]
    expected = cv2.fisheye.projectPoints(points[:, None], np.zeros(3), np.zeros(3), MATRIX, D)[0][:, 0]
    np.testing.assert_allclose(lens.project(3.0 * points), expected, atol=1e-9)
    until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-15)
    back = cv2.fisheye.undistortPoints(expected[:, None], MATRIX, D, criteria=until)[:, 0]
    met = np.abs(cv2.fisheye.distortPoints(back[:, None], MATRIX, D)[:, 0] - expected).max(axis=1) < 1e-10
    assert met.mean() > 0.8  # where OpenCV's own Newton converged: it has no bounds
    unit = np.column_stack([back, np.ones(len(back))])[met]
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    grows = fan_towards(unit, 1e-6)
    steep = np.linalg.norm(lens.project(grows) - lens.project(unit), axis=1) / 1e-6 / MATRIX[0, 0]
    angle = np.linalg.norm(np.cross(unit, lens.directions(expected)[met]), axis=1)
    assert (angle * np.minimum(steep, 1.0)).max() < 1e-9


@pytest.mark.parametrize("model", WIDE)
def test_traced_and_on_the_host_are_one(model: str):
    lens = camera(model)
    directions = fan(min(0.95 * lens.lens.field(lens.distortion), 1.75))
    pixels = lens.project(directions)
    traced = jax.jit(Camera.project)(lens, jnp.asarray(directions, jnp.float32))
    np.testing.assert_allclose(traced, pixels, atol=2e-3)
    np.testing.assert_allclose(jax.jit(Camera.directions)(lens, jnp.asarray(pixels)), directions, atol=1e-5)
    slopes = jax.jacfwd(lambda p: lens.project(p))(jnp.array([0.0, 0.0, 1.0]))
    assert np.isfinite(slopes).all()  # on the axis


@pytest.mark.parametrize("model", WIDE)
def test_closed_forms_of_double_spheres_and_equidistant_at_known_places(model: str):
    """A direction straight aside, worked out by hand from the formulas of the papers."""
    lens, (x, _) = camera(model), camera(model).project(np.array([[1.0, 0.0, 0.0]]))[0]
    at = (x - MATRIX[0, 2]) / MATRIX[0, 0]
    if model == "equidistant":
        quarter = np.pi / 2
        expected = quarter + sum(k * quarter**n for k, n in zip(lens.distortion, (3, 5, 7, 9), strict=True))
    elif model == "ds":
        xi, alpha = lens.distortion
        expected = 1.0 / (alpha * np.sqrt(1.0 + xi * xi) + (1.0 - alpha) * xi)
    elif model == "omni":
        xi, k1, k2, _, p2 = lens.distortion
        r = 1.0 / xi
        expected = r * (1.0 + k1 * r**2 + k2 * r**4) + 3.0 * p2 * r**2
    else:
        alpha, beta = lens.distortion
        expected = 1.0 / (alpha * np.sqrt(beta))
    assert at == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("model", WIDE)
@settings(max_examples=15)
@given(seed=st.integers(0, 999))
def test_derivatives_are_those_of_differences(model: str, seed: int):
    lens = camera(model)
    names = ("f", "aspect", "cx", "cy", *lens.lens.TERMS)
    rays = fan(1.1, 40, seed)
    rays = rays / rays[:, 2:]
    by_ray, moved = pixel_slopes(lens, rays, names)
    step = 1e-6
    for index, name in enumerate(names):
        more, less = (changed_camera(lens, {name: sign * step}) for sign in (1, -1))
        expected = (more.project(rays) - less.project(rays)) / (2 * step)
        np.testing.assert_allclose(moved[index], expected, atol=1e-5 * max(1.0, np.abs(expected).max()))
        pixels = lens.project(rays)
        expected = (more.rays(pixels) - less.rays(pixels))[:, :2] / (2 * step)
        found = ray_slopes(lens, rays, [name])[0]
        np.testing.assert_allclose(found, expected, atol=1e-5 * max(1.0, np.abs(expected).max()))
    for axis in range(2):
        ahead, behind = (lens.project(rays + sign * step * np.eye(3)[axis]) for sign in (1, -1))
        np.testing.assert_allclose(by_ray[..., axis], (ahead - behind) / (2 * step), atol=1e-4)


@pytest.mark.parametrize("model", WIDE)
def test_changes_are_found_again_and_reread_follows_pixels(model: str):
    lens = camera(model)
    changes = {"f": 0.01, "aspect": -0.002, "cx": 3.0, "cy": -2.0, **dict.fromkeys(lens.lens.TERMS, 1e-3)}
    other = changed_camera(lens, changes)
    assert camera_changes(lens, other) == pytest.approx(changes)
    last = lens.lens.TERMS[-1]
    assert intrinsic(other, last) == pytest.approx(intrinsic(lens, last) + 1e-3)
    rays = fan(1.1)
    seen = reread(rays, lens, other)
    np.testing.assert_allclose(other.project(seen), lens.project(rays), atol=1e-9)
    with pytest.raises(InputError, match="s1 is no term"):
        changed_camera(lens, {"s1": 0.001})


def test_a_ray_at_depth_1_ends_where_directions_go_on():
    lens = camera("equidistant", np.zeros(4))
    beyond = np.array([[MATRIX[0, 2] + MATRIX[0, 0] * 1.7, MATRIX[1, 2]]])
    assert np.isnan(lens.rays(beyond)).all()
    np.testing.assert_allclose(lens.directions(beyond), [[np.sin(1.7), 0.0, np.cos(1.7)]], atol=1e-12)
    assert lens.lens_radius == 8.0


@pytest.mark.parametrize(
    ("model", "coefficients", "words"),
    [
        ("equidistant", [0.1, 0.0], "2 coefficients; this lens model takes others: Kannala-Brandt"),
        ("equidistant", [-1e3, 0.0, 0.0, 0.0], "within 5 degrees"),
        ("equidistant", [np.nan, 0.0, 0.0, 0.0], "NaN"),
        ("ds", [-1.0, 0.5], "double sphere"),
        ("ds", [0.1, 1.2], "double sphere"),
        ("eucm", [0.5, 0.0], "extended unified"),
        ("omni", [-0.1, 0.0, 0.0, 0.0, 0.0], "omni model"),
        ("omni", [1.0, -1e3, 0.0, 0.0, 0.0], "omni model"),
        ("omni", [1.0, 0.0], "2 coefficients; this lens model takes others: unified sphere"),
        ("fov", [0.9], "lens model 'fov' is not supported"),
    ],
)
def test_lenses_that_are_none(model: str, coefficients: list[float], words: str):
    kind = UnsupportedModelError if "not supported" in words else InputError
    with pytest.raises(kind, match=words):
        camera(model, coefficients)


@pytest.mark.parametrize("model", WIDE)
def test_one_point_and_none(model: str):
    lens = camera(model)
    point = np.array([0.2, -0.1, 1.0])
    np.testing.assert_array_equal(lens.project(point), lens.project(point[None])[0])
    np.testing.assert_allclose(lens.rays(lens.project(point)), point, atol=1e-12)
    assert lens.project(np.zeros((0, 3))).shape == (0, 2)
    assert lens.rays(np.zeros((0, 2))).shape == (0, 3)
