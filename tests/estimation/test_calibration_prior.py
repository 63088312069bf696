"""What a calibration leaves, and what users may say of it."""

from dataclasses import replace

import numpy as np
import pytest
from lenses import LENSES
from parts_of_estimates import _calibration_prior as of_boards

import stereorecal as sr
from stereorecal.estimation import (
    CalibrationCovariance,
    as_prior,
    calibration_covariances,
    calibration_prior,
    points_of_view,
    readings,
    rig_parameters,
)
from stereorecal.geometry import rotation_from_vector

KAPPAS = of_boards.KAPPAS
LIMITS = {"pitch": 3, "yaw": 3, "roll": 3, "f": 2, "cx": 15, "cy": 15, "k1": 0.05, "p1": 0.005, "p2": 0.005}


@pytest.fixture(scope="module")
def covariances(chart) -> np.ndarray:
    return calibration_covariances(chart)


def deviations(covariances: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("jii->ji", covariances))


def pixels_of(rig: sr.StereoRig, points: np.ndarray) -> np.ndarray:
    """In the left image and in the right one (..., 4)."""
    sides = rig.left.project(points), rig.right.project(points @ rig.rotation.T + rig.translation)
    return np.concatenate([np.asarray(side) for side in sides], axis=-1)


def unit(chart, **changes) -> np.ndarray:
    """θ that is zero but for these."""
    return np.array([changes.get(name.replace(".", "_"), 0.0) for name in chart.names])


def depth_slopes(chart, steps, distance) -> np.ndarray:
    """Relative errors of depth of things at a distance, by θ."""
    points = points_of_view(chart.rig, distance)
    ends = [
        [readings(chart.rig, chart.rig_at(sign * step), points)[1].mean() for sign in (1, -1)]
        for step in np.diag(steps)
    ]
    return (np.diff(ends, axis=1)[:, 0]) / (-2 * steps)


@pytest.mark.parametrize("coefficients", sorted(LENSES))
def test_positive_definite_whatever_the_lens(rig, coefficients):
    camera = sr.Camera((640, 480), rig.left.matrix, np.array(LENSES[coefficients]))
    found = calibration_covariances(rig_parameters(sr.StereoRig(camera, camera, rig.extrinsics)))
    scales = deviations(found)
    correlations = found / scales[:, :, None] / scales[:, None, :]
    np.testing.assert_allclose(correlations, correlations.swapaxes(1, 2), atol=1e-8)
    assert np.linalg.eigvalsh(correlations).min() > 1e-8


def test_where_boards_were_is_not_known(chart, covariances, steps):
    """Rig and the poses of a few boards solved together, densely: what is left of the rig."""
    views, kappa = len(of_boards._KINDS) - 1, 2
    boards = of_boards._boards(chart.rig, of_boards._KINDS[views])

    def pixels(theta, poses):
        turned = [b @ rotation_from_vector(p[:3]).T + p[3:] for b, p in zip(boards, poses.reshape(-1, 6), strict=True)]
        return pixels_of(chart.rig_at(theta), np.stack(turned))

    none, size = np.zeros(6 * len(boards)), chart.dim + 6 * len(boards)
    at = pixels(np.zeros(chart.dim), none)
    inside = ((at >= 0) & (at <= np.array([639, 479, 639, 479]))).all(axis=-1)
    inside &= inside.sum(axis=1, keepdims=True) >= 20
    changes, columns = np.r_[steps, none + 1e-5], []
    for index, change in enumerate(changes):
        step = change * np.eye(size)[index]
        ends = [pixels(sign * step[: chart.dim], sign * step[chart.dim :]) for sign in (1, -1)]
        columns.append((np.where(inside[..., None], ends[0] - ends[1], 0.0) / (2 * change)).ravel())
    limits = of_boards.widest(chart)
    scales = np.r_[limits, none + 0.01]
    rows = np.array(columns).T * scales / (KAPPAS[kappa] * 0.2)
    information = rows.T @ rows + np.diag(np.r_[np.ones(chart.dim), none])
    expected = (np.linalg.inv(information) * np.outer(scales, scales))[: chart.dim, : chart.dim]
    here = chart.names.index("baseline")
    expected[here, here] += 0.15**2
    found = covariances[views * len(KAPPAS) + kappa]
    np.testing.assert_allclose(found / np.outer(limits, limits), expected / np.outer(limits, limits), atol=1e-4)


def test_never_wider_than_what_is_physical(chart, covariances):
    for name, of_name in zip(chart.names, deviations(covariances).T, strict=True):
        assert of_name.min() > 0
        assert of_name.max() <= LIMITS.get(name.split(".")[-1], np.inf)


def test_nothing_depends_on_the_unit_of_the_baseline_nor_on_the_number_of_pixels(rig, covariances):
    long = rig_parameters(rig.with_extrinsics(rig.extrinsics * [1, 1, 1, 1e3, 1e3, 1e3]))
    large = rig_parameters(rig.resized((1280, 960)))
    pixels = np.array([2.0 if parameter.unit == "px" else 1.0 for parameter in large.parameters])
    np.testing.assert_allclose(deviations(calibration_covariances(long)), deviations(covariances), rtol=1e-6)
    np.testing.assert_allclose(deviations(calibration_covariances(large)) / pixels, deviations(covariances), rtol=0.03)


def test_the_loosest_direction_has_a_heavy_tail_that_hardly_moves_boards(chart, prior, covariances, steps):
    """Principal points that differ in x, with all that follows: one direction more, which depth hardly feels, where the
    same centres alone would be a large error."""
    many = len(covariances)
    of_roots = prior.roots @ prior.roots.swapaxes(1, 2)
    assert prior.weights[many:].sum() == pytest.approx(0.3)
    pair = unit(chart, right_cx=1, left_cx=-1)
    slopes = depth_slopes(chart, steps, 5.0)
    for before, after in zip(of_roots[:many], of_roots[many:], strict=True):
        scales = np.sqrt(np.diag(after))
        spread = np.linalg.eigvalsh((after - before) / scales[:, None] / scales)
        assert spread[-1] > 1.0
        assert np.abs(spread[:-1]).max() < 1e-6
        assert 4.0 < np.sqrt(pair @ after @ pair / (pair @ before @ pair)) < 6.0
        # If only centres had moved, by as much, depth would err ten times as far.
        assert slopes @ (after - before) @ slopes < 0.1**2 * (pair @ after @ pair) * (slopes @ pair / 2) ** 2


# --- what users say -------------------------------------------------------------------------------------------


def test_nothing_said_is_the_default(chart, prior):
    for said in (None, "default", {}, prior):
        np.testing.assert_allclose(as_prior(said, chart).roots, prior.roots)


@pytest.mark.parametrize("number", [0.02, np.float32(0.02), np.float64(0.02)])
def test_one_that_is_known_better_is_an_observation_of_it(chart, prior, number):
    """Kalman's update, with the noise that leaves this deviation."""
    here = chart.names.index("left.f")
    for before, after in zip(prior.roots, as_prior({"left.f": number}, chart).roots, strict=True):
        covariance, wanted = before @ before.T, float(number) ** 2
        assert covariance[here, here] > wanted
        noise = 1.0 / (1.0 / wanted - 1.0 / covariance[here, here])
        gain = covariance[:, here] / (covariance[here, here] + noise)
        expected, scales = covariance - np.outer(gain, covariance[here]), np.linalg.norm(before, axis=1)
        np.testing.assert_allclose(
            after @ after.T / np.outer(scales, scales), expected / np.outer(scales, scales), atol=1e-9
        )


def test_several_keep_their_correlations_and_what_follows_them(chart, prior):
    """Named ones have the deviations that were said, and the rest, the named ones known, is as known as before."""
    sigmas = {"right.cx": 0.3, "left.f": 0.05, "yaw": 2.0, "left.k1": 1e-4}
    named = [chart.names.index(name) for name in sigmas]
    found = as_prior(sigmas, chart)
    np.testing.assert_array_equal(found.weights, prior.weights)
    for before, after in zip(prior.roots, found.roots, strict=True):
        blocks = []
        for half in (before, after):
            covariance = half @ half.T / np.outer(*[np.linalg.norm(before, axis=1)] * 2)
            slopes = np.linalg.solve(covariance[np.ix_(named, named)], covariance[named])
            correlations = half[named] / np.linalg.norm(half[named], axis=1, keepdims=True)
            blocks.append((correlations @ correlations.T, slopes, covariance - covariance[:, named] @ slopes))
        np.testing.assert_allclose(np.linalg.norm(after[named], axis=1), list(sigmas.values()), rtol=1e-7)
        for one, other in zip(*blocks, strict=True):
            np.testing.assert_allclose(other, one, atol=1e-5)


def test_a_prior_of_another_rig_is_refused(chart, prior):
    other = type(prior)(prior.weights, prior.means[:, 1:], prior.covariances[:, 1:, 1:])
    with pytest.raises(sr.InputError, match="31 parameters"):
        as_prior(other, chart)


def test_a_covariance_is_taken_at_its_word_in_any_order(chart):
    given = np.array([[4.0, 0.3], [0.3, 0.04]])
    found = as_prior(CalibrationCovariance(("right.cx", "yaw"), given), chart)
    (root,) = found.roots
    where = [chart.names.index(name) for name in ("right.cx", "yaw")]
    np.testing.assert_allclose((root @ root.T)[np.ix_(where, where)], given)
    assert not np.delete(root @ root.T, where, axis=0).any()


@pytest.mark.parametrize(
    ("names", "covariance"),
    [
        (("yaw",), np.eye(2)),
        (("yaw", "yaw"), np.eye(2)),
        (("yaw", "roll"), np.array([[1.0, 2.0], [2.0, 1.0]])),
        (("yaw", "roll"), np.array([[1.0, 0.5], [0.4, 1.0]])),
        (("yaw", "roll"), np.diag([1.0, 0.0])),
        (("yaw", "roll"), np.diag([1.0, np.nan])),
    ],
)
def test_covariances_that_are_none(names, covariance):
    with pytest.raises(sr.InputError):
        CalibrationCovariance(names, covariance)


@pytest.mark.parametrize(
    "wrong", ["exakt", {"left.g": 1.0}, 3, *({"yaw": value} for value in (0.0, float("nan"), np.inf, -1, True, "1"))]
)
def test_priors_that_are_none(chart, wrong):
    with pytest.raises((sr.InputError, TypeError)):
        as_prior(wrong, chart)


def test_rigs_that_differ_in_one_number_have_priors_of_their_own(rig, chart):
    before = calibration_prior(chart)
    matrix = np.array(rig.right.matrix)
    matrix[0, 2] += 20.0
    other = rig_parameters(replace(rig, right=replace(rig.right, matrix=matrix)))
    assert not np.array_equal(calibration_prior(other).roots, before.roots)
    np.testing.assert_array_equal(calibration_prior(rig_parameters(rig)).roots, before.roots)


def test_boards_are_shown_to_telephoto_rigs_where_both_cameras_see_them():
    """Three baselines away, nothing is in both images, and a pair that no board was shown to is hardly known."""
    camera = sr.Camera((640, 480), np.array([[3000.0, 0, 320], [0, 3000.0, 240], [0, 0, 1]]))
    chart = rig_parameters(sr.StereoRig(camera, camera, np.array([0.0, 0.0, 0.0, -0.5, 0.0, 0.0])))
    found = np.sqrt(np.einsum("jii->ji", calibration_covariances(chart)))
    pitch, roll = (found[:, chart.names.index(name)] for name in ("pitch", "roll"))
    assert max(pitch.max(), roll.max()) < 1.0  # degrees; 3 without any board
