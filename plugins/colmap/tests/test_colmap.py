"""COLMAP as a strategy: it conforms, it finds a rig that is known exactly, and says why where it cannot."""

import signal
import subprocess
import sys

import jax
import numpy as np
import pytest
from fixtures import once as once, scene as scene
from image_strategies import RIG, OfImages, coast as coast, images_around, repair

pytest.importorskip("pycolmap", reason="pycolmap is not installed")

from stereorecal_colmap import Colmap
from stereorecal_colmap._cameras import colmap_camera, colmap_pose, extrinsics_of
from stereorecal_colmap._fit import fitted
from stereorecal_colmap._matches import Matches, matched_pixels, pooled

from stereorecal.geometry import Camera, StereoRig
from stereorecal.objectives import StereoImages
from stereorecal.strategies import Outcome, Status
from stereorecal.synthetic import decalibrate
from stereorecal.testing import StrategyConformance

COLMAP = Colmap()
LENSES = {
    "no lens": ("radtan", []),
    "four": ("radtan", [-0.2, 0.05, 0.001, -0.002]),
    "five, of which the last is 0": ("radtan", [-0.2, 0.05, 0.001, -0.002, 0.0]),
    "eight": ("radtan", [0.3, -0.1, 0.001, -0.002, 0.01, 0.35, -0.08, 0.02]),
    "fisheye": ("equidistant", [0.02, -0.01, 0.002, -0.001]),
}


def lens_of(name: str, size: tuple[int, int], focal: float) -> Camera:
    model, coefficients = LENSES[name]
    matrix = np.array([[focal, 0, size[0] / 2 + 3], [0, focal + 1, size[1] / 2 - 2], [0, 0, 1]])
    return Camera(size, matrix, np.array(coefficients), model=model)


class TestColmap(OfImages, StrategyConformance):
    strategy = COLMAP
    lacks = "only 0 matches; 15 are needed"


def test_signals_are_kept_though_an_import_fails(tmp_path, monkeypatch):
    takes_it = "import signal\nsignal.signal(signal.SIGTERM, signal.SIG_DFL)\nraise ImportError"
    (tmp_path / "pycolmap.py").write_text(takes_it)
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.partition(".")[0] == "pycolmap"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delitem(sys.modules, "stereorecal_colmap._fit")
    before = signal.signal(signal.SIGTERM, handler := lambda *_: None)
    try:
        Colmap()
        assert "stereorecal_colmap._fit" not in sys.modules
        assert signal.getsignal(signal.SIGTERM) is handler
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="there are no such signals")
def test_a_signal_comes_through_where_it_runs_in_a_thread():
    """COLMAP's own handler would end the process."""
    code = """
import os, signal, threading
signal.signal(signal.SIGTERM, lambda *_: print("came through"))
from stereorecal_colmap import Colmap
strategy = Colmap()
def work():
    try:
        strategy.run(None, None, 0)
    except AttributeError:
        pass
worker = threading.Thread(target=work)
worker.start()
worker.join()
os.kill(os.getpid(), signal.SIGTERM)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120)
    assert (done.returncode, done.stdout.strip()) == (0, "came through"), done.stderr


def test_it_finds_the_rig(coast):
    images = images_around(decalibrate(RIG, jax.random.key(3), 2.5, 0.025), coast.pairs[:1])
    outcome, (pitch, yaw, roll, x, y, z) = repair(COLMAP, images)
    assert outcome.status is Status.CONVERGED
    assert max(pitch, roll) < 0.03
    assert yaw < 0.1
    assert x == pytest.approx(0.0, abs=1e-12)
    assert max(y, z) < 1.5


def fit(images: StereoImages, matches: Matches) -> Outcome:
    """From the middle of the box."""
    cameras = [colmap_camera(camera, number) for number, camera in enumerate((images.rig.left, images.rig.right), 1)]
    return fitted(COLMAP, images, cameras, matches, np.zeros(images.chart.dim), 0)


def exact_matches(rig: StereoRig, frames: int, count: int = 150, nearest=1.0, farthest=6.0) -> Matches:
    """Matches of points that both cameras see, in COLMAP's pixels, where the centre of the first one is (0.5, 0.5)."""
    draw, pixels = np.random.default_rng(0), []
    for _ in range(frames):
        points = draw.uniform([-0.4, -0.3, 1], [0.4, 0.3, 1], (count, 3)) * draw.uniform(nearest, farthest, (count, 1))
        sides = rig.left.project(points), rig.right.project(points @ rig.rotation.T + rig.translation)
        pixels.append(tuple(np.asarray(side) + 0.5 for side in sides))
    return pooled(pixels)


@pytest.mark.parametrize(("lens", "frames"), [("no lens", 1), ("eight", 2), ("fisheye", 1)])
def test_exact_matches_give_the_exact_rig(lens, frames):
    """A tenth of them is wrong; the right camera stands a little lower and further ahead, so that x is not all."""
    camera = lens_of(lens, (480, 360), 400.0)
    rig = StereoRig(camera, camera, np.array([0.01, -0.02, 0.015, -0.356, 0.02, -0.03]))
    matches = exact_matches(rig, frames)
    wrong = np.arange(len(matches)) % 10 == 0
    matches.right[wrong] += np.random.default_rng(1).uniform(20.0, 40.0, (wrong.sum(), 2))
    images = images_around(rig.with_extrinsics(rig.extrinsics + np.array([0.01, -0.005, 0.01, 0, 0.002, 0.002])))
    outcome = fit(images, matches)
    assert outcome.status is Status.CONVERGED
    kept = int(outcome.message.partition(" ")[0])
    assert 0.8 * len(matches) < kept <= (~wrong).sum() + 2
    found = np.asarray(images.chart.extrinsics(outcome.best))
    np.testing.assert_allclose(np.degrees(found[:3] - rig.extrinsics[:3]), 0.0, atol=2e-3)
    np.testing.assert_allclose(found[3:], rig.extrinsics[3:], atol=1e-4)


@pytest.mark.parametrize("lens", LENSES)
def test_cameras_project_as_ours_do(lens):
    camera = lens_of(lens, (640, 480), 500.0)
    points = np.random.default_rng(0).uniform([-1, -1, 2], [1, 1, 5], (50, 3))
    theirs = np.array([colmap_camera(camera, 1).img_from_cam(point) for point in points])
    np.testing.assert_allclose(theirs, np.asarray(camera.project(points)) + 0.5, atol=1e-8)


def test_poses_go_there_and_back():
    extrinsics = np.array([0.1, -0.2, 0.05, -0.3, 0.02, 0.01])
    pose = colmap_pose(extrinsics)
    point = np.array([0.3, -0.2, 4.0])
    rig = RIG.with_extrinsics(extrinsics)
    np.testing.assert_allclose(pose * point, rig.rotation @ point + rig.translation, atol=1e-12)
    pose.translation = 7.0 * np.asarray(pose.translation)
    np.testing.assert_allclose(extrinsics_of(pose, -0.3), extrinsics, atol=1e-12)


def test_a_lens_that_colmap_does_not_have():
    camera = Camera((480, 360), RIG.left.matrix, np.array([-0.2, 0.6]), model="ds")
    rig = StereoRig(camera, camera, RIG.extrinsics)
    outcome, _ = repair(COLMAP, images_around(rig))
    assert outcome.status is Status.STALLED
    assert outcome.message == "COLMAP has no camera model for these lenses"


def test_fewer_free_axes():
    matches = exact_matches(RIG, 1)
    images = images_around(
        RIG.with_extrinsics(RIG.extrinsics + np.array([0.01, 0, -0.01, 0, 0, 0])), free=("roll", "pitch")
    )
    outcome = fit(images, matches)
    np.testing.assert_allclose(images.chart.extrinsics(outcome.best), RIG.extrinsics, atol=1e-4)


def test_matches_that_agree_on_nothing_stall():
    matches = exact_matches(RIG, 1)
    matches.right[:] = np.random.default_rng(2).uniform(0, 360, matches.right.shape)
    outcome = fit(images_around(RIG), matches)
    assert outcome.status is Status.STALLED
    assert "150 matches" in outcome.message
    np.testing.assert_array_equal(outcome.best, 0.0)


def test_a_rig_outside_the_reach_is_told():
    matches = exact_matches(RIG, 1)
    images = images_around(RIG.with_extrinsics(RIG.extrinsics + np.radians([4.0, 0, 0, 0, 0, 0])))
    outcome = fit(images, matches)
    assert outcome.message.endswith(", outside the reach")
    assert outcome.best[0] == -1.0


def test_points_that_all_lie_far_away_stall():
    """Under COLMAP's least angle of a point, 1.5 degrees, there are none."""
    matches = exact_matches(RIG, 1, nearest=50.0, farthest=90.0)
    outcome = fit(images_around(RIG), matches)
    assert outcome.status is Status.STALLED
    assert outcome.message == "only 0 of 150 matches are kept as points; 15 are needed"


@pytest.mark.slow
def test_matches_lie_where_they_are(coast):
    """On the epipolar lines of the true rig."""
    left, right = matched_pixels(coast.pairs[0])
    rays = [np.asarray(camera.rays(side - 0.5)) for camera, side in ((RIG.left, left), (RIG.right, right))]
    lines = np.cross(RIG.translation, rays[0] @ RIG.rotation.T)
    apart = RIG.right.matrix[0, 0] * (rays[1] * lines).sum(1) / np.linalg.norm(lines[:, :2], axis=1)
    assert abs(np.median(apart)) < 0.05
    assert np.median(np.abs(apart)) < 0.3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"max_reproj_error": 0.0}, "need max_reproj_error > 0"),
        ({"max_refinement_change": np.nan}, "need max_refinement_change > 0"),
        ({"min_tri_angle": -1.0}, "need 0 <= min_tri_angle"),
        ({"max_refinements": 0}, "need max_refinements >= 1"),
        ({"min_matches": 7}, "need min_matches >= 8"),
    ],
)
def test_options_that_make_no_sense(options, message):
    with pytest.raises(ValueError, match=message):
        Colmap(**options)
