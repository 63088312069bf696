"""The rows of a repair's last matches, as a report shows them: over the view, before and after, and along the way."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.geometry import StereoRig, View, rectifying_rotations, with_unit_baseline
from stereorecal.recalibration._schedule import ScoreKind
from stereorecal.recalibration._stages import StageRun, Waypoint
from stereorecal.report.repair_report import Climb, Rows
from stereorecal.scoring import Correspondences, median_row_error, row_differences, with_rays_of

_CELLS = (24, 18)  # columns and rows of the field over the view
_FEWEST = 3  # matches in a cell
_ENOUGH = 0.5  # of the matches of the frame that has most: below that a frame is not the one to show


def row_map(found: Correspondences, initial: StereoRig, candidate: StereoRig, view: View) -> tuple[Rows, int]:
    """Row differences in pixels at full size, and the number of the frame that is shown: the one whose rows lie
    farthest apart under the candidate, of those that match well.

    Args:
        found: with the rays that the cameras of `initial` give, as all stages have them.
    """
    valid = np.asarray(found.weight) > 0
    read = with_rays_of(candidate, found, matched_rig=initial)
    before, after = _differences(found, initial), _differences(read, candidate)
    frame = _worst(after, valid)
    cells = _cells_of_matches(read, candidate, view, valid, frame)
    first, second = (_cell_medians(cells, rows[frame][valid[frame]]) for rows in (before, after))
    return Rows(first, second, before[valid], after[valid]), frame


def climbs_of(stages: Sequence[StageRun]) -> tuple[Climb, ...]:
    """The best count after so many units, of the stages that maximise it."""
    found = []
    for stage in stages:
        for run in stage.runs if stage.stage.score is ScoreKind.COUNT else ():
            finite = np.isfinite(run.trace.values)
            cost, values = run.trace.cost[finite], run.trace.values[finite]
            label = f"best count at scale {stage.scale:.2g}"
            found.append(Climb(label, np.concatenate([[0.0], cost]), np.maximum.accumulate([run.start_value, *values])))
    return tuple(found)


def way_of(found: Correspondences, path: Sequence[Waypoint]) -> Climb:
    """The median row error of the last matches, in pixels, along the search of the extrinsics."""
    errors = [median_row_error(found, with_unit_baseline(point.extrinsics)) for point in path]
    return Climb("median row error [px]", np.array([point.cost for point in path]), np.array(errors))


def _differences(found: Correspondences, rig: StereoRig) -> Float[np.ndarray, "k m"]:
    """Of rays that the cameras of the rig give."""
    return np.asarray(row_differences(found, with_unit_baseline(rig.extrinsics))) / float(found.scale)


def _worst(after: Float[np.ndarray, "k m"], valid: Bool[np.ndarray, "k m"]) -> int:
    numbers = valid.sum(axis=1)
    spread = [
        float(np.quantile(np.abs(rows[found]), 0.9)) if found.sum() >= _ENOUGH * numbers.max() and found.any() else -1.0
        for rows, found in zip(after, valid, strict=True)
    ]
    return int(np.argmax(spread))


def _cells_of_matches(
    found: Correspondences, candidate: StereoRig, view: View, valid: Bool[np.ndarray, "k m"], frame: int
) -> Int[np.ndarray, "f"]:
    """The cell of the candidate's rectified left image in which each match of a frame lies."""
    width, height = view.size
    turn, _ = rectifying_rotations(candidate.rotation, candidate.translation)
    rays = np.asarray(found.left, float)[frame][valid[frame]] @ np.asarray(turn).T
    x, y = view.pixels(rays, 0)
    column = np.clip((x / width * _CELLS[0]).astype(int), 0, _CELLS[0] - 1)
    row = np.clip((y / height * _CELLS[1]).astype(int), 0, _CELLS[1] - 1)
    return row * _CELLS[0] + column


def _cell_medians(cells: Int[np.ndarray, "f"], rows: Float[np.ndarray, "f"]) -> Float[np.ndarray, "h w"]:
    field = np.full(_CELLS[0] * _CELLS[1], np.nan)
    for cell in np.unique(cells):
        inside = rows[cells == cell]
        if len(inside) >= _FEWEST:
            field[cell] = np.median(inside)
    return field.reshape(_CELLS[1], _CELLS[0])
