"""Counts of matched pixels by tile: what a candidate wins and loses, and where."""

import numpy as np
from jaxtyping import Int

from stereorecal.geometry import StereoRig, same_camera, with_unit_baseline
from stereorecal.recalibration._case import Case
from stereorecal.scoring import host


def counts(case: Case, candidate: StereoRig) -> Int[np.ndarray, "2 k tiles"]:
    """Of the tiles of all frames at full scale, under the initial calibration and a candidate."""
    data, rigs = case.images.at(1.0), (case.rig, candidate)
    extrinsics = np.stack([with_unit_baseline(rig.extrinsics) for rig in rigs])
    if same_camera(candidate.left, case.rig.left) and same_camera(candidate.right, case.rig.right):
        return host.counts_by_tile(data, extrinsics, case.matcher)
    through = zip(rigs, extrinsics, strict=True)
    found = [host.counts_by_tile(data.through(rig), of_rig[None], case.matcher) for rig, of_rig in through]
    return np.concatenate(found)


def share_lost(tiles: Int[np.ndarray, "2 k tiles"]) -> float:
    """What a candidate loses in some tiles and does not find there, as a share of all that it matches: a drift leaves
    chance matches, which are few; where half of an image has moved between the exposures, each half fits a rig of its
    own."""
    before, after = tiles.astype(float)
    return float(np.maximum(before - after, 0.0).sum() / max(after.sum(), 1.0))
