"""Views of every projection: round trips, epipolar planes as rows for any rig, distances from disparities."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from lenses import WIDE_LENSES

import stereorecal as sr
from stereorecal import InputError
from stereorecal.geometry import (
    Camera,
    StereoRig,
    View,
    checked_view_arguments,
    mapped_area,
    pixel_map,
    projection,
    rectifying_maps,
    rectifying_rotations,
    rotation_from_euler,
    view,
)
from stereorecal.geometry.projections import NAMES

SIZE = (640, 480)
MATRIX = np.array([[195.0, 0, 322.4], [0, 196.0, 236.1], [0, 0, 1]])
LENS = Camera(SIZE, MATRIX, np.array(WIDE_LENSES["equidistant"]), model="equidistant")
RIG = StereoRig(LENS, LENS, np.array([0, 0, 0, -0.2, 0, 0.0]))
FIELDS = {"pinhole": 100.0, "equirectangular": 175.0}
angle = st.floats(-0.15, 0.15)
share = st.floats(-0.3, 0.3)


@st.composite
def rigs(draw: st.DrawFn) -> StereoRig:
    """Fisheyes, up to 9 degrees about each axis, a baseline mostly sideways."""
    baseline = draw(st.floats(0.01, 2.0))
    translation = [-baseline, draw(share) * baseline, draw(share) * baseline]
    return StereoRig(LENS, LENS, np.array([draw(angle), draw(angle), draw(angle), *translation]))


def directions_of(draw: st.DataObject, farthest: float, count: int = 50) -> np.ndarray:
    """Unit vectors up to an angle off the axis z."""
    rng = np.random.default_rng(draw.draw(st.integers(0, 2**32)))
    off, around = farthest * rng.uniform(0, 1, count), rng.uniform(0, 2 * np.pi, count)
    return np.stack([np.sin(off) * np.cos(around), np.sin(off) * np.sin(around), np.cos(off)], axis=-1)


@pytest.mark.parametrize("name", NAMES)
@given(rig=rigs(), data=st.data(), side=st.integers(0, 1), scale=st.floats(0.25, 1.0))
def test_pixels_to_directions_and_back(name: str, rig: StereoRig, data, side: int, scale: float):
    shown = view(rig, field=FIELDS[name], projection=name).scaled(scale)
    columns, rows = np.random.default_rng(data.draw(st.integers(0, 2**32))).uniform(0, SIZE, (40, 2)).T * scale
    back = shown.pixels(shown.directions(columns, rows, side), side)
    inside = np.broadcast_to(shown.shows(columns, rows, side), columns.shape)
    np.testing.assert_allclose(np.stack(back)[:, inside], np.stack([columns, rows])[:, inside], atol=1e-9)
    given_ = directions_of(data, np.radians(70.0))
    again = shown.directions(*shown.pixels(3.0 * given_, side), side)
    length = shown.formulas.length(*given_.T)
    np.testing.assert_allclose(again * length[:, None], given_, atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
@given(rig=rigs(), data=st.data(), away=st.floats(1.5, 1e4))
def test_epipolar_planes_are_rows_and_disparities_tell_distances(name: str, rig: StereoRig, data, away: float):
    """Points may lie anywhere before both cameras, up to 80 degrees off the middle, or around the left half space."""
    shown = view(rig, field=FIELDS[name], projection=name, zero_disparity=data.draw(st.booleans()))
    to_left, to_right = rectifying_rotations(rig.rotation, rig.translation)
    rectified = directions_of(data, np.radians(75.0)) * away * float(rig.baseline)
    points = rectified @ to_left
    in_right = (points @ rig.rotation.T + rig.translation) @ to_right.T
    ahead = in_right[:, 2] > 0.05 * np.linalg.norm(in_right, axis=1)
    rectified, points, in_right = rectified[ahead], points[ahead], in_right[ahead]
    (column, row), (other, same) = shown.pixels(rectified, 0), shown.pixels(in_right, 1)
    np.testing.assert_allclose(same, row, atol=1e-7)
    nearness = shown.nearness(column, column - other)
    found = shown.directions(column, row, 0) * (float(rig.baseline) / nearness)[:, None]
    np.testing.assert_allclose(found, rectified, rtol=1e-6 * away, atol=1e-9 * away)
    assert (column - other > shown.at_infinity).all()


@given(data=st.data())
def test_rows_and_their_derivatives(data):
    y, z = np.random.default_rng(data.draw(st.integers(0, 2**32))).uniform([-3, 0.05], [3, 2], (30, 2)).T
    x, tiny = y - 0.3, 1e-30
    for formulas in map(projection, NAMES):
        u, v = formulas.project(x, y, z)
        np.testing.assert_array_equal(v, formulas.row(y, z))
        by_y, by_z = (np.imag(formulas.row(*at)) / tiny for at in ((y + tiny * 1j, z), (y, z + tiny * 1j)))
        traced = jax.jacfwd(formulas.row, argnums=(0, 1))(jnp.float32(y[0]), jnp.float32(z[0]))
        np.testing.assert_allclose(traced, [by_y[0], by_z[0]], rtol=1e-4)
        step = 1e-6
        slope = np.imag(formulas.project(x + tiny * 1j, y, z)[0]) / tiny
        np.testing.assert_allclose(slope, (formulas.project(x + step, y, z)[0] - u) / step, rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(v, np.arctan2(y, z), atol=1e-12)


@pytest.mark.parametrize("model", sorted(WIDE_LENSES))
def test_maps_follow_the_directions_over_the_whole_field(model: str):
    """Against the lens on the host, pixel by pixel, beyond 90 degrees too; nothing where the lens shows nothing."""
    matrix = np.array([[150.0, 0, 322.4], [0, 151.0, 236.1], [0, 0, 1]])
    lens = Camera(SIZE, matrix, np.array(WIDE_LENSES[model]), model=model)
    turn, shown = rotation_from_euler(np.array([0.3, -0.2, 0.1])), View((200, 160), 60.0, 100.0, 100.0, 80.0, NAMES[1])
    maps = np.asarray(pixel_map(lens, turn, shown, 0))
    columns, rows = np.meshgrid(np.arange(200.0), np.arange(160.0))
    rays = shown.directions(columns, rows, 0) @ turn
    off = np.arccos(np.clip(rays[..., 2], -1.0, 1.0))
    field = lens.lens.field(lens.distortion)
    seen = shown.shows(columns, rows, 0) & (off < field - 1e-3)
    expected = np.moveaxis(lens.project(rays), -1, 0)
    np.testing.assert_allclose(maps[:, seen], expected[:, seen], atol=2e-3)
    unseen = ~shown.shows(columns, rows, 0) | (off > field + 1e-3)
    assert unseen.any()
    np.testing.assert_array_equal(maps[:, unseen], -1.0)
    assert (off[seen] > np.radians(95.0)).any()


def test_both_images_show_one_point_in_one_row():
    """Through maps of both images, as cv2.remap takes them."""
    rig = RIG.with_extrinsics(np.array([0.02, -0.03, 0.01, -0.2, 0.004, -0.01]))
    shown = view(rig, projection="equirectangular")
    rotations = rectifying_rotations(rig.rotation, rig.translation)
    maps = [np.asarray(one) for one in rectifying_maps(rig.left, rig.right, rotations, shown)]
    assert np.mean([mapped_area(one, SIZE).mean() for one in maps]) > 0.7
    for row, column, disparity in ((100, 300, 20), (240, 150, 35), (400, 500, 5)):
        made = sr.rectification(rig, shown)
        image = np.full(SIZE[::-1], np.nan)
        image[row, column] = disparity
        point = made.points(image)[row, column]
        right = rig.right.project(point @ rig.rotation.T + rig.translation)
        np.testing.assert_allclose(rig.left.project(point), maps[0][:, row, column], atol=2e-3)
        np.testing.assert_allclose(right, maps[1][:, row, column - disparity], atol=2e-3)
        depth = made.depth(image)[row, column]
        np.testing.assert_allclose(depth, (made.R1 @ point)[2], rtol=1e-9)


def test_what_only_a_pinhole_has():
    made = sr.rectification(RIG, view(RIG, projection="equirectangular"))
    for name in ("P1", "P2", "Q"):
        with pytest.raises(InputError, match=f"{name} is a pinhole's, and this view is equirectangular; use maps"):
            getattr(made, name)
    with pytest.raises(InputError, match="the disparity image has the shape"):
        made.depth(np.ones(3))


def test_fields_and_names_that_are_none():
    shown = view(RIG, projection="equirectangular")
    assert shown.degrees == pytest.approx(160.0)  # the lens has 188
    assert view(RIG, projection="equirectangular", field=180.0).degrees == pytest.approx(180.0)
    assert checked_view_arguments({"field": np.int64(180)}) == {"field": 180}
    assert str(shown) == f"640 x 480 pixels, equirectangular, 160 degrees across, focal length {shown.focal:.3f} px"
    for field in (0.0, 180.1, np.nan):
        with pytest.raises(InputError, match="makes no equirectangular view; give more than 0 and at most 180"):
            view(RIG, projection="equirectangular", field=field)
    for make in (lambda: view(RIG, projection="cylinder"), lambda: View(SIZE, 1.0, 0.0, 0.0, 0.0, "cylinder")):
        with pytest.raises(InputError, match="unknown projection 'cylinder'; choose one of: pinhole, equirectangular"):
            make()


@settings(max_examples=20)
@given(rig=rigs())
def test_the_middle_keeps_its_resolution(rig: StereoRig):
    """A small turn moves the middle of the view as it moves the middle of the image."""
    for name in NAMES:
        shown = view(rig, projection=name)
        assert shown.focal >= 0.999 * np.mean([rig.left.focal, rig.right.focal])
        ahead = np.array([[0.0, 0, 1], [1e-4, 0, 1], [0, 1e-4, 1]])
        columns, rows = shown.pixels(ahead, 0)
        assert columns[1] - columns[0] == pytest.approx(1e-4 * shown.focal, rel=1e-4)
        assert rows[2] - rows[0] == pytest.approx(1e-4 * shown.focal, rel=1e-4)


@pytest.mark.parametrize("name", NAMES)
@given(rig=rigs(), data=st.data())
def test_rows_are_as_wide_as_is_said(name: str, rig: StereoRig, data):
    """Against small turns about the baseline and along it: an angle across the epipolar plane takes so many more rows
    than in the middle, and what is far away has so much less disparity."""
    shown = view(rig, field=FIELDS[name], projection=name)
    ray = directions_of(data, np.radians(60.0))
    x, y, z = ray.T
    stretch = np.broadcast_to(shown.formulas.stretch(3.0 * y, 3.0 * z, 3.0), x.shape)
    small, far = 1e-6, 1e6 * ray / shown.formulas.length(*ray.T)[:, None]
    column, row = shown.pixels(ray, 0)
    if name == "equirectangular":
        moved = np.stack([x, y - small * z, z + small * y], axis=-1)  # by as much less as it is nearer to the baseline
        angle = np.linalg.norm(moved - ray, axis=-1)
        rows = np.abs(shown.pixels(moved, 0)[1] - row)
        np.testing.assert_allclose(rows / (shown.focal * angle), stretch, rtol=1e-4)
    column, other = shown.pixels(far, 0)[0], shown.pixels(far - [1.0, 0.0, 0.0], 0)[0]
    np.testing.assert_allclose((column - other) * 1e6 / shown.focal, 1.0 / stretch, rtol=1e-3)
