"""A solution as the plain data of its page."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal._plain import plain
from stereorecal._versions import versions
from stereorecal.geometry import AXES, StereoRig
from stereorecal.objectives import BASELINE
from stereorecal.recalibration._consequences import NORMAL_95
from stereorecal.recalibration._seen_rows import climbs_of, seen_rows, way_of
from stereorecal.recordings import Pair
from stereorecal.report.cells import count, number, percent
from stereorecal.report.repair import Axis, Depth, RepairReport, Sight
from stereorecal.scoring.host import disparity, rectify
from stereorecal.strategies import name_of


def report_of(
    solution: Any,  # a Solution, whose module imports this one
    pairs: Sequence[Pair],
    name: str,
    settings: Mapping[str, Any],
    absent: Sequence[tuple[str, str]],
) -> RepairReport:
    """All that the page about a solution shows.

    Args:
        pairs: those that were repaired, in their order.
        settings: what else is needed to run it again, such as the command.
        absent: frames that did not come to the repair, and why.

    Raises:
        InputError: if the pairs are not those of the solution.
    """
    if not pairs or max(solution.kept, default=0) >= len(pairs):
        raise InputError("these are not the pairs that were repaired; give the same, in the same order.")
    found, rows, frame, way = solution.found, None, 0, None
    if found is not None and found.found:
        rows, frame = seen_rows(found, solution.initial, solution.candidate, solution.view)
        way = way_of(found, solution.initial, solution.candidate, solution.path)
    pair = pairs[solution.kept[frame] if solution.kept else 0]
    expected = solution.expected
    return RepairReport(
        name=name,
        accepted=solution.accepted,
        healthy=solution.reason.healthy,
        reason=solution.reason.value,
        search=f"{solution.message} ({count(solution.evaluations)} evaluations, {solution.seconds:.1f} s)",
        facts=_facts(solution),
        frame=pair.name,
        before=_sight(solution, solution.initial, pair),
        after=_sight(solution, solution.candidate, pair),
        rows=rows,
        misfit=solution.misfit and solution.misfit.as_dict(),
        expected=expected and np.abs(expected.rows) + NORMAL_95 * expected.rows_deviation,
        expected_said=expected and str(expected),
        axes=_axes(solution),
        depths=_depths(solution),
        climbs=climbs_of(solution.stages),
        way=way,
        frames=[*_frames(solution, pairs), *((frame, "not used", why) for frame, why in absent)],
        remarks=_remarks(solution),
        settings={**settings, **_settings(solution)},
        calibrations={
            "before": _calibration(solution.initial),
            f"after ({'accepted' if solution.accepted else 'the candidate, not accepted'})": _calibration(
                solution.candidate
            ),
        },
    )


def _sight(solution: Any, rig: StereoRig, pair: Pair) -> Sight:
    left, right = rectify(rig, pair, view=solution.view)
    found = disparity(rig, pair, matcher=solution.matcher, view=solution.view)
    return Sight(left, right, np.asarray(found.values), np.asarray(found.valid))


def _facts(solution: Any) -> dict[str, tuple[str, str]]:
    before, after = solution.score_before, solution.score_after
    facts = {
        "matched pixels": (percent(before.fraction), percent(after.fraction)),
        "of how many": (count(before.pixels), count(after.pixels)),
    }
    if solution.row_errors is not None:
        facts["row error"] = (f"{solution.row_errors.before:.2f} px", f"{solution.row_errors.after:.2f} px")
    if solution.misfit is not None:
        facts["misfit of regions"] = (f"{solution.misfit.rms_before:.2f} px", f"{solution.misfit.rms:.2f} px")
    return facts


def _axes(solution: Any) -> list[Axis]:
    known, change = solution.uncertainty, solution.change
    found = []
    for index, name in enumerate(AXES):
        factor, unit = (180 / np.pi, "°") if index < 3 else (1e3, "mm")
        half_width, observed = None, True
        called = BASELINE if name == "x" else name
        if known is not None and called in known.names:
            at = known.names.index(called)
            wide = float(known.interval[at]) * (1.0 if index < 3 else 10.0 * float(solution.initial.baseline))
            half_width, observed = (wide if solution.reason.healthy else None), bool(known.observed[at])
        before = factor * float(solution.initial.extrinsics[index])
        found.append(Axis(name, unit, before, before + factor * float(change[index]), half_width, observed))
    return found


def _depths(solution: Any) -> list[Depth]:
    expected, baseline = solution.expected, float(solution.candidate.baseline)
    return [
        Depth(
            distance,
            distance * baseline,
            error,
            expected and (expected.depth_percent[distance].low, expected.depth_percent[distance].high),
        )
        for distance, error in solution.depth_error_percent.items()
    ]


def _frames(solution: Any, pairs: Sequence[Pair]) -> list[tuple[str, str, str]]:
    found = []
    for index, pair in enumerate(pairs):
        if index not in solution.kept:
            found.append((pair.name, "left out", "it shows another rig than the others"))
        elif pair.name in solution.disagreeing:
            found.append((pair.name, "used", "it shows another rig than others"))
        else:
            found.append((pair.name, "used", ""))
    return found


def _remarks(solution: Any) -> list[str]:
    known, left = solution.uncertainty, solution.misfit
    remarks = []
    if left is not None and (solution.reason.name == "MISFIT" or left.high > 0.2):
        remarks.append(f"Misfit of {number(left.high, 2)} px in the worst tenth of the regions: {left.cause.value}.")
    if known is not None and known.undetermined:
        remarks.append(f"Not determined by these images: {'; '.join(known.undetermined)}; it stays as it was.")
    if solution.intrinsics is not None:
        remarks.append(str(solution.intrinsics))
    if solution.ranges is not None:
        remarks.append(f"Ranges: {solution.ranges}.")
    return remarks


def _settings(solution: Any) -> dict[str, Any]:
    stages = [
        f"{run.stage.score.name.lower()} at scale {run.scale:.3g} by {name_of(run.stage.strategy)} "
        f"{asdict(run.stage.strategy)}"
        for run in solution.stages
    ]
    return plain(
        {
            "matcher": {"name": type(solution.matcher).__name__, **asdict(solution.matcher)},
            "stages": stages,
            "free": list(solution.free.names),
            "reach": asdict(solution.reach),
            "cost": f"{solution.cost.total:.1f} units",
            "versions": versions(),
        }
    )


def _calibration(rig: StereoRig) -> dict[str, Any]:
    """As a scene's calib.json has it."""
    cameras = {
        f"{key}_{side}": np.asarray(getattr(getattr(rig, side), name))
        for key, name in (("K", "matrix"), ("D", "distortion"))
        for side in ("left", "right")
    }
    about = {"image_size": list(rig.left.size), **cameras, "distortion_model": "opencv"}
    return plain({**about, "R": np.asarray(rig.rotation), "T": np.asarray(rig.translation)})
