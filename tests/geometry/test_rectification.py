"""Rectifying rotations, views, pixel maps and warps against OpenCV, brute force and finite differences."""

import cv2
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from lenses import FEW, LENSES

from stereorecal.geometry import (
    Camera,
    StereoRig,
    View,
    bilinear_warp,
    mapped_area,
    pixel_map,
    rectifying_maps,
    rectifying_rotations,
    rotation_from_euler,
    view,
)

SIZE = (160, 120)
MATRIX = np.array([[130.0, 0, 78.2], [0, 131.0, 61.1], [0, 0, 1]])
OTHER = np.array([[128.0, 0, 81.5], [0, 129.5, 57.3], [0, 0, 1]])
IDEAL = np.array([0, 0, 0, -0.12, 0, 0])
TEN_DEGREES = np.deg2rad(10.0)

warp, maps_between = jax.jit(bilinear_warp), jax.jit(rectifying_maps)
map_of = jax.jit(pixel_map, static_argnums=3)

angle = st.floats(-TEN_DEGREES, TEN_DEGREES)
side_step = st.floats(-0.3, 0.3)


@st.composite
def extrinsics(draw: st.DrawFn) -> np.ndarray:
    """Up to 10 degrees about each axis; a baseline of 1 cm to 2 m, mostly sideways."""
    baseline = draw(st.floats(0.01, 2.0))
    y, z = draw(side_step), draw(side_step)
    return np.array([draw(angle), draw(angle), draw(angle), -baseline, y * baseline, z * baseline])


def rig(values: np.ndarray = IDEAL, count: int = 5) -> StereoRig:
    lens = np.array(LENSES[count])
    return StereoRig(Camera(SIZE, MATRIX, lens), Camera(SIZE, OTHER, -0.5 * lens if count == 4 else lens), values)


# --- rectifying rotations -----------------------------------------------------------------------------------

_traced_rotations = jax.jit(rectifying_rotations)


@given(extrinsics())
def test_rotations_are_those_of_opencv(values: np.ndarray):
    rotation, translation = rotation_from_euler(values[:3]), values[3:]
    expected = cv2.stereoRectify(
        MATRIX, np.zeros(5), OTHER, np.zeros(5), SIZE, rotation, translation.reshape(3, 1), alpha=0
    )[:2]
    # OpenCV takes rotations below 1e-5 for none.
    negligible = 1e-5 if np.linalg.norm(values[:3]) < 2e-5 else 0.0
    host = rectifying_rotations(rotation, translation)
    traced = _traced_rotations(*(jnp.asarray(a, jnp.float32) for a in (rotation, translation)))
    for side in range(2):
        assert host[side].dtype == np.float64
        np.testing.assert_allclose(host[side], expected[side], atol=1e-9 + negligible)
        np.testing.assert_allclose(traced[side], expected[side], atol=1e-6 + negligible)


@given(extrinsics(), st.floats(0.01, 100.0))
def test_the_length_of_the_baseline_does_not_matter(values: np.ndarray, scale: float):
    rotation = rotation_from_euler(values[:3])
    for a, b in zip(*(rectifying_rotations(rotation, s * values[3:]) for s in (1.0, scale)), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-14)


# --- the view -----------------------------------------------------------------------------------------------


@given(extrinsics(), extrinsics())
@settings(max_examples=10)
def test_the_zoom_follows_the_lenses_alone(first: np.ndarray, second: np.ndarray):
    for count in (0, 5, 14):
        assert view(rig(first, count)).focal == view(rig(second, count)).focal


@pytest.mark.parametrize("count", FEW)
def test_size_zoom_and_centre(count: int):
    stereo = rig(np.array([0.03, -0.05, 0.02, -0.12, 0.004, -0.006]), count)
    mean = (130.0 * 131 * 128 * 129.5) ** 0.25
    each = view(stereo, zero_disparity=False)
    shared = view(stereo)
    assert each.size == shared.size == SIZE
    assert 0.7 * mean <= shared.focal <= mean * (1 + 1e-12)
    assert shared.centre_left == shared.centre_right == pytest.approx((each.centre_left + each.centre_right) / 2)
    # Each camera's image centre lies in the middle column of its own view, and on average in the middle row.
    rows = []
    rotations = rectifying_rotations(stereo.rotation, stereo.translation)
    for camera, rotation, matrix in zip(
        (stereo.left, stereo.right), rotations, (each.matrix_left, each.matrix_right), strict=True
    ):
        ray = np.asarray(camera.rays(np.array([79.5, 59.5])), float)
        x, y, z = matrix @ rotation @ ray
        assert x / z == pytest.approx(79.5, abs=1e-4)
        rows.append(y / z)
    assert np.mean(rows) == pytest.approx(59.5, abs=1e-4)


@pytest.mark.parametrize("scale", [0.5, 0.25])
def test_scaling_the_view_is_resizing_its_images(scale: float):
    """A ramp through the full map, averaged, is the ramp through the scaled map."""
    stereo = rig(np.array([0.03, -0.05, 0.02, -0.12, 0.004, -0.006]), 0)
    full = view(stereo)
    half = full.scaled(scale)
    rotation = rectifying_rotations(stereo.rotation, stereo.translation)[0]
    large = np.asarray(map_of(stereo.left, rotation, full, 0))
    small = np.asarray(map_of(stereo.left, rotation, half, 0))
    averaged = np.stack([cv2.resize(plane, half.size, interpolation=cv2.INTER_AREA) for plane in large])
    np.testing.assert_allclose(averaged, small, atol=0.02)
    # In the resized camera the same place has the coordinates of the resized image.
    resized = stereo.left.resized((round(SIZE[0] * scale), round(SIZE[1] * scale)))
    again = np.asarray(map_of(resized, rotation, half, 0))
    np.testing.assert_allclose(again, (small + 0.5) * scale - 0.5, atol=1e-3)


# --- pixel maps and warps -----------------------------------------------------------------------------------


@pytest.mark.parametrize("count", LENSES)
@pytest.mark.parametrize("seed", range(3))
def test_pixel_map_is_that_of_opencv(count: int, seed: int):
    camera = Camera(SIZE, MATRIX, np.array(LENSES[count]))
    rng = np.random.default_rng(seed)
    rotation = cv2.Rodrigues(rng.uniform(-0.15, 0.15, 3))[0]
    column, row, size = 70 + 20 * rng.random(), 50 + 20 * rng.random(), (171, 113)
    shown = View(size, 115.0, column, column, row)
    opencv = cv2.initUndistortRectifyMap(MATRIX, camera.distortion, rotation, shown.matrix_left, size, cv2.CV_32FC1)
    expected, traced = np.stack(opencv), map_of(camera, rotation, shown, 0)
    assert traced.dtype == jnp.float32
    assert traced.shape == (2, 113, 171)
    np.testing.assert_allclose(traced, expected, atol=0.01)
    assert np.abs(expected - pixels_of(size)).max() > 5  # not the identity


def pixels_of(size: tuple[int, int]) -> np.ndarray:
    return np.stack(np.meshgrid(*map(np.arange, size))).astype(np.float32)


def test_pixels_that_no_ray_of_the_lens_reaches_are_outside():
    barrel = Camera(SIZE, MATRIX, np.array([-0.3, 0, 0, 0]))
    shown = View(SIZE, 20.0, 79.5, 79.5, 59.5)
    wide, coordinates = shown.matrix_left, np.asarray(map_of(barrel, np.eye(3), shown, 0))
    radius = np.linalg.norm((pixels_of(SIZE) - np.array([79.5, 59.5])[:, None, None]) / 20.0, axis=0)
    far, near = radius > barrel.lens_radius + 0.01, radius < barrel.lens_radius - 0.01
    np.testing.assert_array_equal(coordinates[:, far], -1.0)
    assert (coordinates[:, near] != -1.0).all()
    expected = np.stack(cv2.initUndistortRectifyMap(MATRIX, barrel.distortion, np.eye(3), wide, SIZE, cv2.CV_32FC1))
    np.testing.assert_allclose(coordinates[:, near], expected[:, near], atol=0.01)
    folded = far & np.asarray(mapped_area(expected, SIZE))
    assert folded.any()  # OpenCV shows false pixels there


def warped_by_opencv(image: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    return cv2.remap(image, *coordinates, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


@pytest.mark.parametrize("count", FEW)
def test_warp_is_that_of_opencv(count: int):
    stereo = rig(np.array([0.05, -0.08, 0.1, -0.12, 0.01, -0.01]), count)
    image = np.random.default_rng(count).uniform(0, 255, SIZE[::-1]).astype(np.float32)
    image = cv2.GaussianBlur(image, (0, 0), 1.0)
    for coordinates in maps_between(
        stereo.left, stereo.right, rectifying_rotations(stereo.rotation, stereo.translation), view(stereo)
    ):
        assert not np.asarray(mapped_area(coordinates, SIZE)).all()  # the border is part of the test
        expected = warped_by_opencv(image, np.asarray(coordinates))
        # OpenCV rounds coordinates to 1/32 pixel.
        np.testing.assert_allclose(warp(image, coordinates), expected, atol=1.0)
        exact = reference_warp(image, np.asarray(coordinates, float))
        np.testing.assert_allclose(warp(image, coordinates), exact, atol=5e-3)


def reference_warp(image: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Bilinear interpolation written as four corners with a padded border, in float64."""
    height, width = image.shape
    x, y = (np.clip(coordinates[i], 0, n - 1) for i, n in ((0, width), (1, height)))
    padded = np.pad(image.astype(float), ((0, 1), (0, 1)), mode="edge")
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    u, v = x - x0, y - y0
    return (
        padded[y0, x0] * (1 - u) * (1 - v)
        + padded[y0, x0 + 1] * u * (1 - v)
        + padded[y0 + 1, x0] * (1 - u) * v
        + padded[y0 + 1, x0 + 1] * u * v
    )


@given(st.lists(st.tuples(st.floats(-3, 12, width=32), st.floats(-3, 9, width=32)), min_size=1, max_size=20))
def test_mapped_area_is_what_lies_inside(points: list[tuple[float, float]]):
    size = (9, 6)
    points = [*points, (0.0, 0.0), (8.0, 5.0), (-1.0, -1.0), (8.0, 5.0001), (-1e-6, 2.0)]
    inside = mapped_area(np.array([points], np.float32).T, size)[:, 0]
    assert [bool(value) for value in inside] == [0 <= x <= 8 and 0 <= y <= 5 for x, y in np.float32(points)]


# --- gradients through maps and warps -----------------------------------------------------------------------

SCENE = rig(IDEAL, 5)
VIEW = view(SCENE)


def maps_of(values):
    rotation = rotation_from_euler(values[:3])
    return jnp.stack(rectifying_maps(SCENE.left, SCENE.right, rectifying_rotations(rotation, values[3:]), VIEW))


INNER = np.s_[:, :, 25:-25:6, 25:-25:6]  # away from the border, where the warp has a kink


def loss(left, right):
    return ((left - right - 5.0) ** 2).sum()


@pytest.mark.slow
def test_gradients_of_map_and_warp():
    maps, jacobian = jax.jit(lambda v: maps_of(v)[INNER]), jax.jit(jax.jacfwd(lambda v: maps_of(v)[INNER]))
    noise = np.random.default_rng(0).uniform(0, 255, SIZE[::-1]).astype(np.float32)
    image = cv2.GaussianBlur(noise, (0, 0), 3.0)
    gradient = jax.jit(jax.grad(lambda v: loss(*(bilinear_warp(image, one) for one in maps_of(v)[INNER]))))
    steps = np.diag([2e-3, 2e-3, 2e-3, 5e-3, 5e-4, 5e-4]).astype(np.float32)

    for values in (IDEAL, [0.02, -0.03, 0.01, -0.12, 0.004, -0.003]):
        start = jnp.asarray(values, jnp.float32)
        derivative = np.moveaxis(np.asarray(jacobian(start), float), -1, 0)
        assert np.isfinite(derivative).all()
        for change, step in zip(derivative, steps, strict=True):
            ahead, behind = (np.asarray(maps(start + s * step), float) for s in (1, -1))
            differences = (ahead - behind) / (2 * step.max())
            np.testing.assert_allclose(change, differences, atol=2e-3 * np.abs(differences).max() + 0.03)

        # The warp by the chain rule: float64 differences of the reference warp along the map's derivative.
        coordinates = np.asarray(maps(start), float)
        expected = []
        for change in derivative:
            ahead, behind = (loss(*(reference_warp(image, c) for c in coordinates + s * change)) for s in (1e-8, -1e-8))
            expected.append((ahead - behind) / 2e-8)
        largest = np.abs(expected).max()
        np.testing.assert_allclose(gradient(start), expected, atol=1e-3 * largest)
        assert np.abs(expected)[[0, 1, 2, 4, 5]].min() > 1e-3 * largest  # each axis but x matters


def test_gradients_are_finite_where_rays_turn_behind_the_camera():
    def total(values):
        return jnp.sum(maps_of(values) * 1e-3)

    gradient = jax.jit(jax.grad(total))(jnp.asarray([0.0, 2.9, 0.0, -0.12, 0.0, 0.0], jnp.float32))
    assert np.isfinite(gradient).all()


def test_gradients_are_finite_where_rays_lie_in_the_plane_of_the_image():
    sideways = jnp.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    shown = View((9, 9), 100.0, 4.0, 4.0, 4.0)  # column 4 looks exactly along x: z = 0

    def total(rotation):
        return jnp.sum(pixel_map(SCENE.left, rotation, shown, 0))

    value, gradient = jax.jit(jax.value_and_grad(total))(sideways)
    assert np.isfinite(value)
    assert np.isfinite(gradient).all()


@pytest.mark.parametrize("focals", [(600.0, 700.0), (700.0, 600.0)])
def test_a_pinhole_view_shows_the_whole_image_of_the_wider_camera(focals):
    left, right = (
        Camera((640, 480), np.array([[f, 0.0, 319.5], [0.0, f, 239.5], [0.0, 0.0, 1.0]]), np.zeros(5)) for f in focals
    )
    rig = StereoRig(left, right, np.array([0.0, 0.0, 0.0, -0.12, 0.0, 0.0]))
    assert view(rig).focal == pytest.approx(600.0, rel=3e-3)
