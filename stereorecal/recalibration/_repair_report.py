"""A solution as the plain data of its page."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal._arrays import json_data
from stereorecal._errors import InputError
from stereorecal._version import versions
from stereorecal.decision import Reason
from stereorecal.geometry import PINHOLE, StereoRig, View, rectifying_rotations, with_unit_baseline
from stereorecal.io import calibration_json
from stereorecal.recalibration._facts import NOTHING_SEEN, SAYS_NOTHING, changed_axes, changed_intrinsics, facts_of
from stereorecal.recalibration._result import AbstractResult, Condition
from stereorecal.recalibration._settings import settings_as_data
from stereorecal.recalibration._uncertainty import NORMAL_95
from stereorecal.recordings import Pair
from stereorecal.report.number_text import count, percent
from stereorecal.report.repair_report import Conclusion, RepairReport, Rows, Sight
from stereorecal.scoring import Correspondences, row_differences, with_rays_of
from stereorecal.scoring.host import disparity, rectify

_CELLS = (24, 18)  # columns and rows of the field over the view
_FEWEST = 3  # matches in a cell
_ENOUGH = 0.5  # of the matches of the frame that has most: below that a frame is not the one to show


def row_map(found: Correspondences, initial: StereoRig, candidate: StereoRig, view: View) -> tuple[Rows, int]:
    """Row differences in pixels at full size, and the number of the frame that is shown: the one whose rows lie
    farthest apart under the candidate, of those that match well; the cameras of `initial` give the rays of the
    matches."""
    valid = np.asarray(found.weight) > 0
    read = with_rays_of(candidate, found, matched_rig=initial)
    before, after = _differences(found, initial), _differences(read, candidate)
    frame = _worst(after, valid)
    cells = _cells_of_matches(read, candidate, view, valid, frame)
    first, second = (_cell_medians(cells, rows[frame][valid[frame]]) for rows in (before, after))
    return Rows(first, second, before[valid], after[valid]), frame


def _differences(found: Correspondences, rig: StereoRig) -> Float[np.ndarray, "k m"]:
    """The row differences of rays that the cameras of the rig give."""
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


def report_of(
    solution: AbstractResult,
    pairs: Sequence[Pair],
    name: str,
    command: str | None,
    settings: Mapping[str, Any],
    absent: Sequence[tuple[str, str]],
) -> RepairReport:
    """All that the page about a solution shows.

    Args:
        pairs: those that were given, in their order.
        command: that repeats it, if it was one.
        settings: what else is needed to run it again; the advice names its `output`, if it has one.
        absent: frames that did not come to the repair, and why.

    Raises:
        InputError: if the pairs are not those of the solution.
    """
    if not pairs or max(solution.selected, default=0) >= len(pairs):
        raise InputError("these are not the pairs that were repaired; give the same, in the same order.")
    matched = [pairs[number] for number in solution.selected]
    found, rows, frame = solution.found, None, 0
    telling = solution.reason not in SAYS_NOTHING
    if found is not None and found.found and telling:
        rows, frame = row_map(found, solution.initial, solution.candidate, solution.view)
    pair = matched[frame]
    expected, depths = solution.expected, ", ".join(f"{error} at {error.where}" for error in solution.depth)
    rows_said = expected and f"epipolar error {expected.rows_px:.2f} px where the images show something"
    before, after = _sights(solution, pair)
    conclusion = conclusion_of(solution.reason)
    if not solution.searched and solution.condition is Condition.CANNOT_TELL:
        conclusion = Conclusion.UNKNOWN  # also where a repair would say more
    title = "after" if conclusion is Conclusion.REPAIRED else "candidate, which was not taken"
    return RepairReport(
        name=name,
        conclusion=conclusion,
        verdict=solution.verdict,
        advice=solution.advice.replace("FILE", str(settings.get("output") or "FILE")),
        text=str(solution),
        search=f"{solution.message} ({count(solution.evaluations)} evaluations, {solution.seconds:.1f} s)",
        baseline=float(solution.rig.baseline),
        facts=_facts(solution, telling=telling),
        frame=pair.name,
        before=before,
        after=after,
        rows=rows,
        misfit=solution.misfit.as_dict() if solution.misfit is not None and telling else None,
        expected=expected and np.abs(expected.rows) + NORMAL_95 * expected.rows_deviation,
        expected_said=rows_said and f"{rows_said}; depth {depths}",
        axes=changed_axes(solution) if telling else (),
        intrinsics=changed_intrinsics(solution) if telling else (),
        depths=list(zip(solution.depth_before, solution.depth, strict=True)),
        frames=[
            *_frames(solution, matched),
            *((what, "not used", why) for what, why in (*absent, *_not_matched(solution, len(pairs)))),
        ],
        remarks=[fact.sentence for fact in facts_of(solution) if fact.remark] if telling else (),
        command=command,
        settings={**_settings_and_outcome(solution), **settings},
        view=None if solution.view.projection == PINHOLE else str(solution.view),
        calibrations={"before": calibration_json(solution.initial), title: calibration_json(solution.candidate)},
        searched=solution.searched,
    )


def conclusion_of(reason: Reason) -> Conclusion:
    """What became of the calibration, for those who read a page."""
    if reason in NOTHING_SEEN or reason is Reason.CANNOT_TELL:
        return Conclusion.UNKNOWN
    if not reason.healthy:
        return Conclusion.REFUSED
    return Conclusion.REPAIRED if reason.accepted else Conclusion.GOOD


@lru_cache(maxsize=1)  # a page and a recording show the same; many solutions must not keep their images
def _sights(solution: AbstractResult, pair: Pair) -> tuple[Sight, Sight]:
    """A pair under the initial calibration and under the candidate."""
    return _sight(solution, solution.initial, pair), _sight(solution, solution.candidate, pair)


def _sight(solution: AbstractResult, rig: StereoRig, pair: Pair) -> Sight:
    left, right = rectify(rig, pair, view=solution.view)
    found = disparity(rig, pair, matcher=solution.matcher, view=solution.view)
    return Sight(left, right, np.asarray(found.values), np.asarray(found.valid))


def _facts(solution: AbstractResult, *, telling: bool) -> dict[str, tuple[str, str]]:
    before, after = solution.score_before, solution.score_after
    facts = {f"matched, of {count(before.pixels)} pixels": (percent(before.fraction), percent(after.fraction))}
    errors = solution.row_errors
    if errors is not None and telling:
        facts["epipolar error of the matches"] = (f"{errors.before:.2f} px", f"{errors.after:.2f} px")
    if solution.misfit is not None and telling:
        facts["misfit of regions"] = (f"{solution.misfit.rms_before:.2f} px", f"{solution.misfit.rms:.2f} px")
    return facts


def _frames(solution: AbstractResult, pairs: Sequence[Pair]) -> list[tuple[str, str, str]]:
    found = []
    for index, pair in enumerate(pairs):
        if index not in solution.used:
            found.append((pair.name, "left out", "it shows another rig than the others"))
        elif pair.name in solution.disagreeing:
            found.append((pair.name, "used", "it shows another rig than others"))
        else:
            found.append((pair.name, "used", ""))
    return found


def _not_matched(solution: AbstractResult, given: int) -> Iterator[tuple[str, str]]:
    """How many of the pairs that were given were not matched, and why."""
    dropped = 0 if solution.prior_use is None else solution.prior_use.dropped
    if dropped:
        yield f"{dropped} {'pair' if dropped == 1 else 'pairs'}", "used by an earlier repair"
    if rest := given - len(solution.selected) - dropped:
        yield f"{rest} other {'pair' if rest == 1 else 'pairs'}", "others show more texture"


def _settings_and_outcome(solution: AbstractResult) -> dict[str, Any]:
    """What was asked for, and what the run made of it."""
    settings = settings_as_data(solution.settings)
    stages = [f"{run.stage.solver} at scale {run.scale:.3g}" for run in solution.stages]
    outcome = {
        "view": str(solution.view),
        "matcher": settings["matcher"] | asdict(solution.matcher),  # with the range that was measured
        "stages that ran": "; ".join(stages) or "none",
        "cost": f"{solution.cost.total:.1f} units",
        "versions": versions(),
    }
    return json_data(settings | outcome)
