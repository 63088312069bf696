"""Cameras: projection and its inverse, resizing, what is refused."""

import pickle
from dataclasses import replace
from typing import Any

import cv2
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from lenses import FEW, LENSES

from stereorecal import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, changed_camera, distort, same_camera, turn_of, turned_pixels, undistort

SIZE = (96, 64)
WIDE = {
    "equidistant": [0.1, 0.01, -0.01, 0.001],
    "ds": [-0.2, 0.6],
    "eucm": [0.6, 1.1],
    "omni": [1.0, -0.1, 0.05, 0.01, 0.02],
}
MATRIX = np.array([[80.0, 0, 46.2], [0, 82.0, 33.1], [0, 0, 1]])


def camera(count: int, size: tuple[int, int] = SIZE) -> Camera:
    return Camera(size, MATRIX, np.array(LENSES[count]))


def pixels_of(size: tuple[int, int]) -> np.ndarray:
    """All pixel centres, (h, w, 2)."""
    return np.stack(np.meshgrid(*map(np.arange, size)), axis=-1).astype(float)


@pytest.mark.parametrize("count", LENSES)
def test_projection_is_that_of_opencv(count: int):
    points = np.random.default_rng(count).uniform([-1, -0.8, 1.5], [1, 0.8, 4], (200, 3))
    expected = cv2.projectPoints(points, np.zeros(3), np.zeros(3), MATRIX, np.array(LENSES[count]))[0][:, 0]
    np.testing.assert_allclose(camera(count).project(points), expected, atol=1e-9)
    traced = jax.jit(Camera.project)(camera(count), jnp.asarray(points, jnp.float32))
    np.testing.assert_allclose(traced, expected, atol=1e-3)


@pytest.mark.parametrize("count", FEW)
def test_rays_invert_the_projection_over_the_whole_image(count: int):
    pixels, lens = pixels_of(SIZE), camera(count)
    rays = lens.rays(pixels)
    assert rays.shape == (*SIZE[::-1], 3)
    np.testing.assert_array_equal(rays[..., 2], 1.0)
    np.testing.assert_allclose(lens.project(rays), pixels, atol=1e-9)
    if count == 14:
        np.testing.assert_allclose(jax.jit(Camera.rays)(lens, pixels), rays, atol=2e-6)


@pytest.mark.parametrize("count", LENSES)
def test_undistort_inverts_distort(count: int):
    points = np.random.default_rng(count).uniform(-0.55, 0.55, (*SIZE[::-1], 2))
    coefficients = np.array(LENSES[count])
    distorted = distort(points, coefficients)
    assert np.abs(distorted - points).max() > (1e-3 if count else -1)
    np.testing.assert_allclose(undistort(distorted, coefficients), points, atol=1e-12)
    np.testing.assert_allclose(undistort(jnp.asarray(distorted), coefficients), points, atol=2e-6)


@pytest.mark.parametrize("count", [5, 14])
@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
def test_jacobian_of_the_distortion(count: int, jacobian):
    coefficients, step = np.array(LENSES[count]), 1e-6
    for point in (np.zeros(2), np.array([0.3, -0.4])):
        actual = jax.jit(jacobian(lambda p: distort(p, coefficients)))(jnp.asarray(point, jnp.float32))
        ahead, behind = (
            np.stack([distort(point + s * e, coefficients) for e in np.eye(2)], axis=-1) for s in (step, -step)
        )
        np.testing.assert_allclose(actual, (ahead - behind) / (2 * step), atol=1e-5)


def test_lens_radius_is_where_the_image_folds_back():
    assert Camera(SIZE, MATRIX).lens_radius >= 8.0
    # d/dr (r + k1 r^3) = 0 at r = 1 / sqrt(-3 k1)
    assert Camera(SIZE, MATRIX, np.array([-0.3, 0, 0, 0])).lens_radius == pytest.approx((0.9) ** -0.5, abs=0.003)
    assert camera(5).resized((48, 32)).lens_radius == camera(5).lens_radius


@pytest.mark.parametrize("size", [(48, 32), (24, 16), (192, 128), (32, 64)])
def test_resized_keeps_pixel_corners(size: tuple[int, int]):
    """INTER_AREA averages whole pixels: a ramp tells which place of the old image each new pixel shows."""
    small = camera(5).resized(size)
    assert small.size == size
    if size[0] <= SIZE[0] and size[1] <= SIZE[1]:
        old_places = cv2.resize(pixels_of(SIZE), size, interpolation=cv2.INTER_AREA)
    else:
        old_places = (pixels_of(size) + 0.5) * np.array(SIZE) / np.array(size) - 0.5
    points = np.random.default_rng(0).uniform([-0.4, -0.3, 1], [0.4, 0.3, 1], (50, 3))
    new, old = small.project(points), camera(5).project(points)
    columns = np.interp(new[:, 0], np.arange(size[0]), old_places[0, :, 0])
    rows = np.interp(new[:, 1], np.arange(size[1]), old_places[:, 0, 1])
    inside = ((new >= 0) & (new <= np.array(size) - 1)).all(axis=1)
    assert inside.sum() > 30
    np.testing.assert_allclose(np.stack([columns, rows], -1)[inside], old[inside], atol=1e-9)


@pytest.mark.parametrize(
    ("corner", "start"), [(None, (8, 5)), ((0, 0), (0, 0)), ((16, 11), (16, 11)), ((3, 7), (3, 7))]
)
def test_cropped_sees_the_same_elsewhere(corner: tuple[int, int] | None, start: tuple[int, int]):
    size = (SIZE[0] - 16, SIZE[1] - 11)
    part = camera(14).cropped(size, corner)
    assert part.size == size
    points = np.random.default_rng(0).uniform([-0.4, -0.3, 1], [0.4, 0.3, 1], (50, 3))
    np.testing.assert_allclose(part.project(points) + start, camera(14).project(points), rtol=0, atol=1e-9)
    assert part.lens_radius == camera(14).lens_radius


@pytest.mark.parametrize(
    ("size", "corner"),
    [
        ((SIZE[0] + 1, SIZE[1]), None),
        (SIZE, (1, 0)),
        ((10, 10), (-1, 0)),
        ((10, 10), (SIZE[0] - 9, 0)),
    ],
)
def test_cropped_stays_inside(size, corner):
    with pytest.raises(InputError, match="cannot be cut out of an image of"):
        camera(5).cropped(size, corner)


def bad(**entries: float) -> np.ndarray:
    matrix = MATRIX.copy()
    for name, value in entries.items():
        matrix[int(name[1]), int(name[2])] = value
    return matrix


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ({"m00": np.nan}, "NaN"),
        ({"m02": np.inf}, "NaN or infinite"),
        ({"m00": 0.0}, "singular or negative"),
        ({"m11": -80.0}, "singular or negative"),
        ({"m22": 0.0}, "singular or negative"),
        ({"m20": 0.1}, "singular or negative"),
        ({"m01": 0.5}, "skew"),
        ({"m10": 0.5}, "skew"),
        *(({"m00": focal, "m11": focal}, "do not fit a camera with 96 pixels") for focal in (1e300, 1e7, 0.001)),
        *(({"m02": centre}, "lies far outside of the image") for centre in (1e9, -1e9)),
    ],
)
def test_matrices_that_are_none(entries: dict[str, float], words: str):
    with pytest.raises(InputError, match=words):
        Camera(SIZE, bad(**entries))


@pytest.mark.parametrize("place", range(5))
def test_no_lens_distorts_so_much(place: int):
    with pytest.raises(InputError, match="no lens distorts so much"):
        Camera(SIZE, MATRIX, np.where(np.arange(5) == place, 1e300, 0.0))


@pytest.mark.parametrize("size", [(0, 10), (10, -1), None, 10, ("10", "10"), (10, np.nan), (10.5, 10)])
def test_sizes_that_are_none(size: Any):
    given = Camera(SIZE, MATRIX)
    object.__setattr__(given, "size", size)  # past the types that tests check, which users' programs do not
    with pytest.raises(InputError, match="image size"):
        given.__post_init__()


@given(st.integers(1, 16).filter(lambda n: n not in LENSES))
def test_counts_of_coefficients_that_opencv_does_not_know(count: int):
    with pytest.raises(UnsupportedModelError, match=f"{count} coefficients"):
        Camera(SIZE, MATRIX, np.zeros(count))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_coefficients_that_are_not_finite(value: float):
    with pytest.raises(InputError, match="NaN or infinite"):
        Camera(SIZE, MATRIX, np.array([0.1, 0.0, value, 0.0]))


def test_the_camera_owns_its_numbers():
    matrix = MATRIX.copy()
    lens = Camera(SIZE, matrix)
    matrix[:] = 0.0
    np.testing.assert_array_equal(lens.matrix, MATRIX)
    assert lens.matrix.dtype == lens.distortion.dtype == np.float64


def test_pytree_and_pickle():
    lens = camera(14)
    for copy in (jax.tree.map(lambda leaf: leaf, lens), pickle.loads(pickle.dumps(lens))):
        assert type(copy) is Camera
        assert copy.size == SIZE
        np.testing.assert_array_equal(copy.matrix, lens.matrix)
        np.testing.assert_array_equal(copy.distortion, lens.distortion)
        assert copy.lens_radius == lens.lens_radius
    assert jax.tree.map(lambda leaf: object(), lens).size == SIZE  # placeholders pass


def test_zeros_at_the_end_make_no_other_lens():
    lens = np.array([-0.1, 0.02, 1e-3, 0.0])
    four, five, none, zero = (Camera(SIZE, MATRIX, D) for D in (lens, np.append(lens, 0.0), np.zeros(0), np.zeros(4)))
    assert same_camera(four, five)
    assert same_camera(none, zero)
    assert not same_camera(four, zero)
    assert not same_camera(four, Camera(SIZE, MATRIX, np.append(lens, 1e-3)))


def test_a_lens_model_grows_only_for_what_changes():
    """A file of five coefficients must be able to hold a rig whose focal length changed."""
    camera = Camera((640, 480), np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]]), np.zeros(5))
    assert changed_camera(camera, {"f": 0.01, "k3": 0.0, "s4": 0.0}).distortion.size == 5
    assert changed_camera(camera, {"s4": 1e-4}).distortion.size == 12


@pytest.mark.parametrize("quarters", [-1, 1, 2, 3])
@pytest.mark.parametrize("name", [*LENSES, *WIDE])
def test_a_camera_of_a_turned_image(name: int | str, quarters: int):
    """Tilts about both axes turn by 180 degrees only."""
    lens = np.array(LENSES[name] if isinstance(name, int) else WIDE[name], float)
    one = Camera(SIZE, MATRIX, lens, model="radtan" if isinstance(name, int) else name)
    if lens.size > 12 and quarters != 2:
        with pytest.raises(InputError, match="tilted about both axes"):
            one.turned(quarters)
        one = replace(one, distortion=np.where(np.arange(lens.size) == 12, 0.0, lens))
    other, points = one.turned(quarters), np.random.default_rng(1).uniform([-1, -0.8, 2], [1, 0.8, 4], (200, 3))
    expected = turned_pixels(one.project(points), SIZE, quarters)
    np.testing.assert_allclose(other.project(points @ turn_of(quarters).T), expected, atol=1e-9)
    back = other.turned(-quarters)
    assert (back.size, back.lens_radius) == (one.size, one.lens_radius)
    np.testing.assert_allclose(back.matrix, one.matrix, rtol=1e-15)
    np.testing.assert_array_equal(back.distortion, one.distortion)


@pytest.mark.parametrize("quarters", range(-2, 4))
def test_pixels_of_a_turned_image(quarters: int):
    """As `np.rot90` has them."""
    image = np.arange(35).reshape(5, 7)
    turned = np.rot90(image, quarters)
    columns, rows = turned_pixels(pixels_of((7, 5)), (7, 5), quarters).astype(int).transpose(2, 0, 1)
    np.testing.assert_array_equal(turned[rows, columns], image)
