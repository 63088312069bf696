"""What the matches of a look show: the row error, and which parts of the view, at which distances, they cover."""

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.decision import ENOUGH
from stereorecal.estimation import nearness_of
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import RigChart, differences_at
from stereorecal.recalibration import DISTANCES, tile_medians
from stereorecal.scoring import Correspondences

PARTS = (3, 3)  # rows and columns of the left image
# Baselines, halfway between the distances at which depth is read.
BAND_EDGES = tuple(np.sqrt(np.multiply(DISTANCES[:-1], DISTANCES[1:])).tolist())


def row_error(found: Correspondences, chart: RigChart, theta: Float[np.ndarray, "n"]) -> float:
    """|Row difference| of the rig at θ, pixels at full size: the mean over the tiles of a tile's median."""
    valid = np.asarray(found.weight) > 0
    differences = differences_at(found, chart, theta)[valid] / float(found.scale)
    return float(np.mean(tile_medians(differences, np.asarray(found.tile)[valid])))


def part_of(rig: StereoRig, points: Float[np.ndarray, "p 3"]) -> Int[np.ndarray, "p"]:
    """The part of the left image in which each point appears, numbered by rows."""
    pixels = np.asarray(rig.left.project(points / points[:, 2:]))
    share = pixels / np.array(rig.left.size) * PARTS[::-1]
    column, row = np.clip(share.astype(int), 0, np.array(PARTS[::-1]) - 1).T
    return row * PARTS[1] + column


def as_taken(part: int, rig: StereoRig) -> tuple[int, int]:
    """Row and column of a part in the left image as it was taken, before the rig's `turns`."""
    numbers = np.arange(PARTS[0] * PARTS[1]).reshape(PARTS)
    row, column = np.argwhere(np.rot90(numbers, -rig.turns[0]) == part)[0].tolist()
    return row, column


def band_of(baselines: Float[np.ndarray, "*n"] | float) -> Int[np.ndarray, "*n"]:
    """The number of the distance that each distance counts to."""
    return np.searchsorted(BAND_EDGES, baselines)


def no_coverage() -> Int[np.ndarray, "parts distances"]:
    """The coverage before the first look."""
    return np.zeros((PARTS[0] * PARTS[1], len(DISTANCES)), int)


def covered_by(found: Correspondences, rig: StereoRig, view: View) -> Bool[np.ndarray, "parts distances"]:
    """Whether a look through a rig shows each part of the view at each distance: in as large a share of the part as a
    whole image must be covered by."""
    valid = np.asarray(found.weight[0]) > 0
    left, right = (np.asarray(rays[0], float)[valid] for rays in (found.left, found.right))
    away = 1.0 / np.maximum(nearness_of(rig, left, right, view), 1e-9)
    counts = no_coverage()
    np.add.at(counts, (part_of(rig, left), band_of(away)), 1)
    return counts >= ENOUGH.covered * found.weight.shape[1] / len(counts)
