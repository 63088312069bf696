"""What a single pair shows at other rows: where a part of it moved between the exposures, windows do not match the rows
that match elsewhere. Unseen, it could not speak against a rig that fits the rest."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.geometry import StereoRig, with_unit_baseline
from stereorecal.recalibration._acceptance import FEWEST_PLACES
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._stages import StageRun
from stereorecal.recalibration._unmatched import LIKELY
from stereorecal.scoring import Correspondences, host, image_quality

_OTHER_ROWS = (-3.0, 3.0)  # pixels at the scale of the stage: windows see what is 1.5 off, and nearly all that moved
_MISSED = 0.2  # of what has texture: less cannot outweigh what matches


def with_other_rows(case: Case, run: StageRun, end_rig: StereoRig) -> StageRun:
    """A stage; if its correspondences are of one pair and miss much of its texture, with those at other rows, in tiles
    where these are more, and more than there may be by chance; if there are enough of such tiles for a verdict.

    Args:
        end_rig: under which the stage's own were found, with the cameras of the case's rig.
    """
    found = run.found
    assert found is not None
    pair, *others = case.images.pairs
    if others or found.covered >= (1.0 - _MISSED) * image_quality(pair).texture:
        return run
    data, extrinsics = case.images.at(run.scale, run.stage.frames), with_unit_baseline(end_rig.extrinsics)
    moved = np.zeros(len(_share_of_tiles(found)), bool)
    for rows in _OTHER_ROWS:
        pitch = rows / float(found.focal)
        other = host.correspondences(data, extrinsics + pitch * np.eye(6)[0], case.matcher)
        share = _share_of_tiles(other)
        better = (share > _share_of_tiles(found)) & (share > LIKELY)
        found, moved = _chosen(better, other, found), moved | better
    return replace(
        run,
        found=found if moved.sum() >= FEWEST_PLACES else run.found,
        matching_cost=run.matching_cost + len(_OTHER_ROWS) * data.cost,
    )


def _share_of_tiles(found: Correspondences) -> Float[np.ndarray, "t"]:
    """Of the cells of each tile that have a correspondence."""
    tile, seen = np.ravel(found.tile), np.ravel(found.weight) > 0
    return np.bincount(tile, seen) / np.bincount(tile)


def _chosen(tiles: Bool[np.ndarray, "t"], some: Correspondences, others: Correspondences) -> Correspondences:
    """Some correspondences in these tiles, and others in the rest."""
    cells = tiles[np.asarray(some.tile)]

    def of_cells(name: str) -> np.ndarray:
        a, b = np.asarray(getattr(some, name)), np.asarray(getattr(others, name))
        return np.where(cells.reshape(*cells.shape, *[1] * (a.ndim - cells.ndim)), a, b)

    return replace(others, **{name: of_cells(name) for name in ("left", "right", "weight")})
