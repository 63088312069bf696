"""Matches of a single pair at vertical offsets: a region that moved between the exposures by several rows finds no
match at those of the rest. Unseen, it could not speak against a rig that fits the rest."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.geometry import StereoRig, with_unit_baseline
from stereorecal.recalibration._acceptance import FEWEST_PLACES
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._stages import StageRun
from stereorecal.recalibration._unmatched import LIKELY
from stereorecal.scoring import Correspondences, host, image_quality

_OFFSETS = (-3.0, 3.0)  # pixels at the scale of the stage: rows are refined by 2, so 1 to 5 up and down are seen


def with_vertical_offsets(case: Case, run: StageRun, end_rig: StereoRig) -> StageRun:
    """A stage; if its correspondences are of one pair, cover more than chance matches do, and miss a quarter of the
    texture, with those at vertical offsets, in tiles that have twice as many of them: regions that moved. If these are
    fewer tiles than a verdict takes, they cannot outweigh the rest, and nothing changes.

    Where intrinsics are free, the images are matched once more, and this is left out.

    Args:
        end_rig: where the stage ended, with the cameras of the case's rig.
    """
    found, pairs = run.found, case.images.pairs
    assert found is not None
    if len(pairs) > 1 or case.free.intrinsics:
        return run
    texture = image_quality(next(iter(pairs))).texture
    if not LIKELY * texture <= found.covered < (1.0 - LIKELY) * texture:
        return run
    data, extrinsics = case.images.at(run.scale, run.stage.frames), with_unit_baseline(end_rig.extrinsics)
    moved = np.zeros(len(_share_of_tiles(found)), bool)
    for rows in _OFFSETS:
        pitch = rows / float(found.focal)
        offset = host.correspondences(data, extrinsics + pitch * np.eye(6)[0], case.matcher)
        share = _share_of_tiles(offset)
        better = share > np.maximum(2.0 * _share_of_tiles(found), LIKELY)
        found, moved = _in_tiles(better, offset, found), moved | better
    return replace(
        run,
        found=found if moved.sum() >= FEWEST_PLACES else run.found,
        matching_cost=run.matching_cost + len(_OFFSETS) * data.cost,
    )


def _share_of_tiles(found: Correspondences) -> Float[np.ndarray, "t"]:
    """Of the cells of each tile that have a correspondence."""
    tile, seen = np.ravel(found.tile), np.ravel(found.weight) > 0
    return np.bincount(tile, seen) / np.maximum(np.bincount(tile), 1)


def _in_tiles(tiles: Bool[np.ndarray, "t"], offset: Correspondences, found: Correspondences) -> Correspondences:
    """Those at an offset in these tiles, and in all others those that were found."""
    cells = tiles[np.asarray(found.tile)]

    def merged(name: str) -> np.ndarray:
        a, b = np.asarray(getattr(offset, name)), np.asarray(getattr(found, name))
        return np.where(cells.reshape(*cells.shape, *[1] * (a.ndim - cells.ndim)), a, b)

    weight = merged("weight")
    mean = weight.sum() / max(np.count_nonzero(weight), 1)
    return replace(found, left=merged("left"), right=merged("right"), weight=weight / (mean or 1.0))
