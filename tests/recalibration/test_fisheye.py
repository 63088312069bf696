"""Rendered rigs with fisheye lenses, from their own calibration to a repaired one."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import stereorecal as sr
from stereorecal.geometry import Camera, StereoRig, axis_errors, changed_camera

SIZE = (320, 240)


def fisheye(field: float, columns: float, rows: float, scale: float = 1.0) -> Camera:
    focal = 0.5 * SIZE[0] / np.radians(0.5 * field)
    matrix = np.array([[focal, 0, columns], [0, 1.002 * focal, rows], [0, 0, 1]])
    return Camera(SIZE, matrix, scale * np.array([-0.02, -0.007, 0.002, -0.001]), model="equidistant")


def rig_of(field: float) -> StereoRig:
    extrinsics = np.array([0.004, -0.006, 0.003, -0.36, 0.002, -0.001])
    return StereoRig(fisheye(field, 161.2, 118.0), fisheye(field, 158.5, 120.5, 0.9), extrinsics)


@pytest.fixture(scope="module")
def scene():
    return sr.synthetic.render("street", 1, rig=rig_of(130.0))


DRIFT = np.array([np.radians(0.5), np.radians(-0.7), np.radians(0.9), 0.0, 0.004, -0.003])


def test_cv2_rectifies_with_our_maps_as_with_its_own(scene):
    """R1 and P1 into cv2.fisheye's own maps, and the rows of both images through ours."""
    rig, made = scene.rig, sr.rectification(scene.rig, {"projection": "pinhole"})
    for camera, turn, projection, maps in (
        (rig.left, made.R1, made.P1, made.maps[0]),
        (rig.right, made.R2, made.P2, made.maps[1]),
    ):
        own = cv2.fisheye.initUndistortRectifyMap(
            camera.matrix, camera.distortion, turn, projection[:, :3], SIZE, cv2.CV_32FC1
        )
        shown = maps[0] >= 0
        assert shown.mean() > 0.9
        np.testing.assert_allclose(np.stack(maps)[:, shown], np.stack(own)[:, shown], atol=1e-3)


def test_lens_terms_are_named_and_held_to_the_model(scene):
    with pytest.raises(sr.InputError, match=r"left\.p1 is no parameter of a lens of the model 'equidistant'"):
        sr.recalibrate(scene.rig, scene.pairs, free=("extrinsics", "left.p1"))
    chart = sr.estimation.rig_parameters(scene.rig)
    assert [name for name in chart.names if name.startswith("left.k")] == ["left.k1", "left.k2", "left.k3", "left.k4"]
    theta = np.random.default_rng(0).uniform(-1e-3, 1e-3, chart.dim)
    np.testing.assert_allclose(chart.coordinates_of(chart.rig_at(theta)), theta, atol=1e-9)


@pytest.mark.parametrize("field", [130.0, 190.0])
def test_what_a_calibration_leaves_is_made_through_the_lens(field: float):
    """Each of the angles of a wide rig is known to a part of a degree: boards fill its image."""
    from stereorecal.estimation import calibration_covariances

    chart = sr.estimation.rig_parameters(rig_of(field))
    for covariance in calibration_covariances(chart):
        assert np.linalg.eigvalsh(covariance).min() > 0
        assert np.sqrt(np.diag(covariance))[:3].max() < 1.0
    slightly, much = (np.sqrt(np.diag(calibration_covariances(chart)[index])) for index in (0, 4))
    assert (much > slightly).all()


@pytest.mark.parametrize(("field", "projection"), [(60.0, "pinhole"), (100.0, "pinhole"), (115.0, "equirectangular")])
def test_the_view_of_a_wide_model_follows_what_a_pinhole_can_show(field: float, projection: str):
    """A lens has the same kind of view whatever model describes it; no drift turns one kind into the other."""
    rig = rig_of(field)
    view = sr.view(rig)
    assert view.projection == projection
    assert view.degrees == pytest.approx(field, rel=0.05)
    assert view.focal >= 0.7 * np.mean([rig.left.focal, rig.right.focal])
    assert sr.view(rig.with_extrinsics(rig.extrinsics + DRIFT)).projection == projection
    # A field that is asked for, likewise; and a pinhole's own rig has nothing but pinhole views.
    middle = 2.0 * np.degrees(np.arctan(0.5 * SIZE[0] / np.mean([rig.left.focal, rig.right.focal])))
    assert sr.view(rig, field=0.9 * middle).projection == "pinhole"
    assert sr.view(rig, field=150.0).projection == "equirectangular"
    assert sr.view(sr.synthetic.default_rig(), field=150.0).projection == "pinhole"


@pytest.mark.slow
def test_arguments_of_views_by_name(scene):
    rig, pairs = scene.rig, scene.pairs
    asked = {"projection": "pinhole", "field": 80}
    assert sr.score(rig, pairs, view=asked) == sr.score(rig, pairs, view=sr.view(rig, field=80.0))
    assert sr.rectification(rig, asked).view.degrees == pytest.approx(80.0)
    for wrong, said in (
        ({"fields": 80}, "unknown argument of a view 'fields'; did you mean field"),
        ({"field": "80"}, "the field of a view is '80'; give degrees, more than 0 and at most 180"),
        ({"field": 170.0, "projection": "pinhole"}, "more than 0 and at most 165 of pinhole"),
        ({"projection": "fisheye"}, "unknown projection 'fisheye'; choose one of: pinhole, equirectangular"),
        ({"zero_disparity": None}, "give True or False"),
        (140.0, "the view is a float; give an sr.View"),
    ):
        for look in (sr.score, sr.health, sr.recalibrate):
            with pytest.raises(sr.InputError, match=said):
                look(rig, pairs, view=wrong)


def test_a_double_sphere_has_its_resolution_in_the_middle():
    """The same lens, as two models have it: 1 / (1 + xi) of a double sphere's focal length is the resolution."""
    camera = Camera(SIZE, np.array([[100.0, 0, 160], [0, 100.0, 120], [0, 0, 1]]), np.array([-0.2, 0.55]), model="ds")
    near = np.array([[1e-6, 0.0, 1.0]])
    assert camera.focal[0] == pytest.approx((camera.project(near)[0, 0] - 160.0) / 1e-6, rel=1e-6)
    rig = StereoRig(camera, changed_camera(camera, {"xi": 0.01}), np.array([0, 0, 0, -0.1, 0, 0]))
    assert sr.view(rig).focal == pytest.approx(camera.focal[0], rel=0.02)


@pytest.fixture(scope="module")
def very_wide():
    return sr.synthetic.render("street", 1, rig=rig_of(190.0))


def test_a_very_wide_rig_is_repaired_in_an_equirectangular_view(very_wide):
    start = very_wide.rig.with_extrinsics(very_wide.rig.extrinsics + DRIFT)
    solution = sr.recalibrate(start, very_wide.pairs, matcher=sr.BM(num_disparities=48))  # which need not be compiled
    view = solution.view
    assert solution.accepted
    assert view.projection == "equirectangular"  # since a pinhole cannot show what the lens does
    assert f"view     {view}" in str(solution)
    assert max(list(axis_errors(solution.rig, very_wide.rig).values())[:3]) < 0.2
    assert sr.difference(solution.rig, very_wide.rig, view=view).row_error_median < 0.2
    assert solution.score_after.count > 1.1 * solution.score_before.count
    # What is to be expected is of the same view: rows of what lies far aside, too.
    expected = solution.expected
    assert expected is not None
    assert np.isfinite(expected.rows).mean() > 0.7
    assert expected.rows_px < 0.5
    apart = sr.difference(start, very_wide.rig, view=view)
    assert apart.row_error_median > 1.0


def test_disparities_of_an_equirectangular_view_are_those_of_the_truth(very_wide):
    """By OpenCV's matcher, in both directions of depth: the truth's disparities, and its points."""
    rig, pair = very_wide.rig, very_wide.pairs[0]
    view = sr.view(rig, projection="equirectangular")
    made = sr.rectification(rig, view)
    left, right = (
        cv2.remap(np.asarray(image, np.uint8), *maps, cv2.INTER_LINEAR)
        for image, maps in zip((pair.left, pair.right), made.maps, strict=True)
    )
    found = cv2.StereoSGBM.create(0, 32, 7, 8 * 49, 32 * 49, 1, uniquenessRatio=10).compute(left, right) / 16.0
    truth = sr.synthetic.ground_truth("street", 1, rig=rig, view=view)
    seen = (found > 1.0) & ~truth.occluded
    assert seen.mean() > 0.2
    assert np.median(np.abs(found - truth.disparity)[seen]) < 0.5
    beside = seen & (np.abs(np.arange(SIZE[0]) - view.centre_left) > view.focal)  # 57 degrees and more
    assert beside.sum() > 200
    assert np.median(np.abs(found - truth.disparity)[beside]) < 0.6
    far = np.linalg.norm(made.points(np.where(seen, found, np.nan)), axis=-1)
    true = np.linalg.norm(made.points(np.where(seen, truth.disparity, np.nan)), axis=-1)
    assert np.nanmedian(np.abs(far / true - 1.0)) < 0.15


@pytest.mark.slow
def test_a_fisheye_beside_a_pinhole():
    """Each camera has its own lens."""
    wide = rig_of(100.0)
    pinhole = Camera(SIZE, np.array([[150.0, 0, 160], [0, 150.0, 120], [0, 0, 1]]), np.array([-0.1, 0.01, 0, 0, 0]))
    rig = replace(wide, right=pinhole)
    scene = sr.synthetic.render("street", 2, rig=rig)
    names = sr.estimation.rig_parameters(rig).names
    assert {"left.k4", "right.p1"} <= set(names)
    assert not {"left.p1", "right.k4"} & set(names)
    solution = sr.recalibrate(rig.with_extrinsics(rig.extrinsics + DRIFT), scene.pairs, prior="exact")
    assert solution.accepted
    assert max(list(axis_errors(solution.rig, rig).values())[:3]) < 0.1


def test_a_good_rig_whose_lenses_leave_corners_black_is_healthy(scene):
    width, height = scene.rig.left.size
    rows, columns = np.mgrid[:height, :width]
    shown = np.hypot(columns - width / 2, rows - height / 2) < 0.45 * width
    seen = scene.pairs[0]
    left, right = (np.where(shown, image, 4.0).astype(np.float32) for image in (seen.left, seen.right))
    assert sr.health(scene.rig, [sr.Pair(left, right)]).healthy
