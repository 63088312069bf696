"""What is known of θ before any image: what a calibration leaves, the covariance of the errors of a chessboard
calibration; and the drift since.

The former is the inverse Fisher information of simulated views of a board, whose poses are marginalised. Its
correlations are the point: whatever keeps boards in place (a principal point with a rotation, a focal length with z) is
loose, whatever moves the depth of a board is tight.

The drift is one event of unknown size, or more rarely one that turns one axis alone. Pitch and roll, which rows tell
for sure, say how far yaw, which they do not, has probably moved.
"""

from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._consequences import AHEAD
from stereorecal.estimation._mixture import Mixture
from stereorecal.estimation._rig_parameters import pixels_of, slopes_by_point, slopes_of
from stereorecal.geometry import Camera, StereoRig, rotation_between, rotation_from_vector
from stereorecal.objectives import BASELINE, ROTATION, SIDES, RigChart

SIZES = (0.002, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0)  # degrees, of the angles; the first is none
_SHIFT = 0.6  # y and z as a share of the baseline, per radian
_ALONE = 0.02  # probability of a drift that turns one axis more than the others, of each axis
_LEAST_ALONE = 0.1  # degrees
_CORNER_NOISE = 0.2  # pixels, standard deviation of a corner in an image 640 wide
# How much worse than their noise calibrations are, told apart by the evidence of the images.
KAPPAS = (0.5, 1.0, 2.0, 4.0, 8.0)
# The direction that boards leave loosest, principal points that differ in x with a yaw and tangential terms that keep
# boards where they are, has heavier tails than the others: public rigs have it at several deviations.
_PAIR_WORSE = 5.0
_PAIR_PROBABILITY = 0.3


@cache
def drift_sizes() -> tuple[Float[np.ndarray, "k 5"], Float[np.ndarray, "k"]]:
    """Standard deviations of pitch, yaw, roll [degrees], y and z [% of the baseline] for each kind of drift, and the
    probability of each before any image is seen."""
    shift = 100.0 * _SHIFT * np.pi / 180.0
    together = [[size, size, size, shift * size, shift * size] for size in SIZES]
    alone = []
    for axis in range(len(ROTATION)):
        for size, row in zip(SIZES, together, strict=True):
            for larger in SIZES:
                if larger >= _LEAST_ALONE and larger > 2.0 * size:
                    alone.append([larger if index == axis else value for index, value in enumerate(row)])
    share = len(ROTATION) * _ALONE
    weights = np.r_[np.full(len(together), (1.0 - share) / len(together)), np.full(len(alone), share / len(alone))]
    return np.array([*together, *alone]), weights


class _Views(NamedTuple):
    """How a board was shown.

    Attributes:
        boards: how many views.
        depths: nearest and farthest, baselines.
        tilt: at most, degrees.
        off_centre: centre of the board from that of the image, at most, as a share of the image.
        widths: smallest and largest, as a share of the image.
    """

    boards: int
    depths: tuple[float, float]
    tilt: float
    off_centre: float
    widths: tuple[float, float]


# A careful calibration, a hasty one, one of a few views that are nearly frontal: what is loose differs between them.
_KINDS = (
    _Views(12, (3.0, 12.0), 35.0, 0.3, (0.33, 0.5)),
    _Views(6, (3.0, 12.0), 20.0, 0.2, (0.33, 0.5)),
    _Views(4, (3.0, 8.0), 15.0, 0.2, (0.25, 0.4)),
)
_AXIS = np.array([0.0, 0.0, 1.0])
_CORNERS = (9, 6)
_FEWEST = 20  # corners that both cameras see
_SEED = 7
_WIDTH = 640
# Never wider than what is physical.
_WIDEST = {"f": 2.0, "aspect": 0.5, "cx": 15.0, "cy": 15.0, "k1": 0.05, "k2": 0.1, "p1": 0.005, "p2": 0.005, "k3": 0.1}
_WIDEST |= dict.fromkeys(("s1", "s2", "s3", "s4"), 0.01)
_WIDEST |= {"k4": 0.1, "xi": 0.05, "alpha": 0.05, "beta": 0.1}  # of wide lenses
_WIDEST_ANGLE, _WIDEST_SHIFT, _WIDEST_LENGTH = 3.0, 5.0, 2.0  # degrees, percent of the baseline
_LEAST_OVERLAP = 2.5  # over the relative disparity at which boards are still in both images
SQUARES = 0.15  # percent: printed squares are off by so much, and the baseline's length with them
# Some more: printers scale pages to fit, and sizes are typed wrongly. It matters where ranges tell the length.
_SCALED, _SCALED_PROBABILITY = 3.0, 0.1


@dataclass(frozen=True)
class _ChartKey:
    """A chart, equal to another one of the same numbers."""

    numbers: Hashable
    chart: RigChart = field(compare=False)


def calibration_prior(chart: RigChart) -> Mixture:
    """What a chessboard calibration of the rig at θ = 0 leaves; read-only, since others are given the same."""
    leaves, structure = jax.tree.flatten(chart.rig)
    numbers = tuple(np.asarray(leaf).tobytes() for leaf in leaves)
    return _calibration_prior(_ChartKey((structure, numbers, chart.parameters, chart.wide), chart))


@lru_cache(maxsize=8)  # a repair asks several times, and so does who looks at one pair after the other
def _calibration_prior(key: _ChartKey) -> Mixture:
    plain = calibration_covariances(key.chart)
    both = np.concatenate([plain, [_with_pair(key.chart, covariance) for covariance in plain]])
    weights = np.repeat([1.0 - _PAIR_PROBABILITY, _PAIR_PROBABILITY], len(plain)) / len(plain)
    prior = Mixture(weights, np.zeros((len(both), key.chart.dim)), both)
    for values in (prior.weights, prior.means, prior.covariances):
        values.flags.writeable = False
    return prior


def _with_pair(chart: RigChart, covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """The covariance with a difference of the principal points in x, and all that follows it, so much worse."""
    left, right = (chart.names.index(f"{side}.cx") for side in SIDES)
    follows = covariance[:, right] - covariance[:, left]
    return covariance + (_PAIR_WORSE**2 - 1.0) * np.outer(follows, follows) / (follows[right] - follows[left])


def with_scaled_boards(prior: Mixture, chart: RigChart) -> Mixture:
    """The same, but the squares of the boards may have been of another size than was said, and the baseline of another
    length: no image shows it."""
    longer = prior.beside(np.diag([_SCALED**2 * (name == BASELINE) for name in chart.names]))
    return Mixture(
        np.concatenate([(1.0 - _SCALED_PROBABILITY) * prior.weights, _SCALED_PROBABILITY * prior.weights]),
        np.concatenate([prior.means, prior.means]),
        np.concatenate([prior.covariances, longer.covariances]),
    )


def exact_prior(chart: RigChart) -> Mixture:
    """Nothing is wrong but what has drifted: the paper's assumption."""
    return Mixture.single(np.zeros(chart.dim), np.zeros((chart.dim, chart.dim)))


def physical_prior(chart: RigChart, squares: float = SQUARES) -> Mixture:
    """No more than what is physical: where the boards of the calibration are at hand, they tell what it left, and the
    same boards must not count again as a simulated calibration. Their squares have lengths of this standard deviation,
    percent."""
    of_squares = np.array([squares * (name == BASELINE) for name in chart.names])
    return Mixture.single(np.zeros(chart.dim), np.diag(widest(chart) ** 2 + of_squares**2))


def calibration_covariances(chart: RigChart) -> Float[np.ndarray, "j n n"]:
    """The covariance of θ that a calibration leaves: for each kind of views, one after the other, each of KAPPAS."""
    physical = np.diag(1.0 / widest(chart) ** 2)
    noise = _CORNER_NOISE * chart.rig.left.size[0] / _WIDTH
    scale, of_squares = widest(chart), np.diag([SQUARES**2 * (name == BASELINE) for name in chart.names])
    found, boards = [], [_boards(chart.rig, views) for views in _KINDS]
    of_boards = _information(chart, np.concatenate(boards))  # of all kinds at once
    for of_kind in np.split(of_boards, np.cumsum([len(some) for some in boards])[:-1]):
        for kappa in KAPPAS:
            information = of_kind.sum(axis=0) / (kappa * noise) ** 2 + physical
            inverse = np.linalg.inv(scale[:, None] * information * scale)
            found.append(scale[:, None] * inverse * scale + of_squares)
    return np.stack(found)


def widest(chart: RigChart) -> Float[np.ndarray, "n"]:
    """The largest standard deviations that are physical, in the units of θ."""
    width = chart.rig.left.size[0] / _WIDTH
    found = []
    for parameter in chart.parameters:
        if "." in parameter.name:
            found.append(_WIDEST[parameter.name.split(".")[1]] * (width if parameter.unit == "px" else 1.0))
        elif parameter.unit == "deg":
            found.append(_WIDEST_ANGLE)
        else:
            found.append(_WIDEST_LENGTH if parameter.name == BASELINE else _WIDEST_SHIFT)
    return np.array(found)


def _information(chart: RigChart, points: Float[np.ndarray, "b c 3"]) -> Float[np.ndarray, "b n n"]:
    """The Fisher information of the corners of each board with a noise of one pixel, its pose marginalised."""
    rig = chart.rig
    at = pixels_of(rig, points)
    width, height = rig.left.size
    visible = ((at >= 0.0) & (at <= np.array([width, height, width, height]) - 1.0)).all(axis=-1)
    visible &= _ahead(rig, points)
    visible &= (visible.sum(axis=1) >= _FEWEST)[:, None]
    by_rig, by_pose = slopes_of(chart, np.zeros(chart.dim), points), _by_pose(rig, points)
    slopes = np.where(visible[..., None], np.concatenate([by_rig, by_pose]), 0.0)  # (n + 6, boards, corners, 4)
    boards = np.moveaxis(slopes, 1, 0).reshape(len(points), len(slopes), -1)
    normal, n = boards @ boards.swapaxes(1, 2), chart.dim
    cross, own = normal[:, n:, :n], normal[:, n:, n:]
    return normal[:, :n, :n] - cross.swapaxes(1, 2) @ np.linalg.pinv(own, hermitian=True) @ cross


def _ahead(rig: StereoRig, points: Float[np.ndarray, "*c 3"]) -> Bool[np.ndarray, "*c"]:
    """Whether points are before both cameras, as those must be that have a ray (x/z, y/z, 1)."""
    right = points @ rig.rotation.T + rig.translation
    return np.minimum(points[..., 2], right[..., 2]) > AHEAD * np.linalg.norm(points, axis=-1)


def _boards(rig: StereoRig, views: _Views) -> Float[np.ndarray, "b c 3"]:
    """The corners of boards, metres in the frame of the left camera; always the same for a rig."""
    draw = np.random.default_rng(_SEED)
    (width, height), baseline = rig.left.size, float(rig.baseline)
    flat = np.stack(np.meshgrid(*(np.arange(n) - 0.5 * (n - 1) for n in _CORNERS)), axis=-1).reshape(-1, 2)
    boards = []
    most = np.radians(views.tilt)
    # Telephoto rigs see boards with both cameras only from farther away.
    farther = max(1.0, _LEAST_OVERLAP * float(rig.left.focal[0]) / width / views.depths[0])
    for _ in range(views.boards):
        depth = baseline * farther * draw.uniform(*views.depths)
        square = depth * draw.uniform(*views.widths) * width / float(rig.left.focal[0]) / _CORNERS[0]
        middle = (0.5 + draw.uniform(-views.off_centre, views.off_centre, 2)) * [width, height]
        tilt = rotation_from_vector(draw.uniform(-most, most, 3))
        corners = np.concatenate([square * flat, np.zeros((len(flat), 1))], axis=-1) @ np.asarray(tilt).T
        if rig.left.lens.WIDE:  # people turn the board to the camera, wherever it is in the image
            ray = _direction(rig.left, middle)
            boards.append(corners @ rotation_between(_AXIS, ray).T + depth * ray)
        else:
            boards.append(corners + depth * np.asarray(rig.left.rays(middle[None]))[0])
    return np.stack(boards)


def _direction(camera: Camera, pixel: Float[np.ndarray, "2"]) -> Float[np.ndarray, "3"]:
    """The direction of a pixel, or of one nearer to the middle, where the lens shows something."""
    while not np.isfinite(ray := np.asarray(camera.directions(pixel[None]))[0]).all():
        pixel = 0.5 * (pixel + np.asarray(camera.matrix)[:2, 2])
    return ray


def _by_pose(rig: StereoRig, points: Float[np.ndarray, "b c 3"]) -> Float[np.ndarray, "6 b c 4"]:
    """Derivatives of the pixels of boards by a turn about their middle, and by a shift in sizes of a board."""
    arms = points - points.mean(axis=1, keepdims=True)
    size = np.linalg.norm(arms, axis=-1).max(axis=1)[:, None, None]
    moved = [np.cross(axis, arms) for axis in np.eye(3)] + [size * axis + 0.0 * arms for axis in np.eye(3)]
    return (slopes_by_point(rig, points) @ np.stack(moved)[..., None])[..., 0]
