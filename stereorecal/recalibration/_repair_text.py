"""A solution as the plain data of its lines of text."""

import numpy as np

from stereorecal.estimation import DEFAULT, EXACT
from stereorecal.geometry import AXES, PINHOLE
from stereorecal.objectives import BASELINE
from stereorecal.recalibration._acceptance import Reason
from stereorecal.recalibration._regional_misfit import WORTH_SAYING, Cause, Misfit
from stereorecal.recalibration._result import AbstractResult
from stereorecal.recalibration._windows import described
from stereorecal.report.number_text import change, depths
from stereorecal.report.repair_report import Axis
from stereorecal.report.repair_text import RepairText
from stereorecal.report.short_list import short_list

_WOULD_TELL = "four scenes or more, with ranges or frames taken while the rig moves, would determine them"
_SYSTEMATIC = 0.05  # pixels of radial misfit that regions share; right intrinsics leave 0.01


def text_of(solution: AbstractResult) -> RepairText:
    """All that is printed of a solution."""
    verdict = "accepted" if solution.accepted else "not accepted, the initial calibration stays"
    rows = solution.row_errors
    before, after = ("", "") if rows is None else (f", row error {px:.2f} px" for px in (rows.before, rows.after))
    return RepairText(
        verdict=f"{verdict}: {solution.reason.value}",
        search=f"{solution.message} ({solution.evaluations} evaluations, {solution.seconds:.1f} s)",
        before=f"{solution.score_before}{before}",
        after=f"{solution.score_after}{after}",
        axes=axes_of(solution),
        remarks=_remarks(solution),
    )


def axes_of(solution: AbstractResult) -> list[Axis]:
    """The change of each of the extrinsics, in degrees and millimetres; its interval only where the rig to use is good:
    else it would be that of an answer that was found wrong."""
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
        found.append(Axis(name, unit, before, factor * float(change[index]), half_width, observed))
    return found


def _remarks(solution: AbstractResult) -> list[tuple[str, str]]:
    said, seen, use, known = [], solution.estimate, solution.prior_use, solution.uncertainty
    if solution.view.projection != PINHOLE:
        said.append(("view", str(solution.view)))
    said += [("check", doubt) for doubt in solution.doubts]
    if use is not None and str(use) not in (DEFAULT, EXACT):
        said.append(("prior", str(use)))
    if solution.misfit is not None and (left := _misfit(solution, solution.misfit)):
        said.append(("misfit", left))
    if solution.intrinsics is not None:
        said.append(("", str(solution.intrinsics)))
    if solution.ranges is not None:
        said.append(("ranges", str(solution.ranges)))
    if seen is not None and seen.windows:
        said.append(("motion", described(seen)))
    if solution.left_out:
        said.append(("", f"left out, since they disagree with the others: {', '.join(solution.left_out)}"))
    if solution.disagreeing:
        said.append(("", f"these disagree with others: {', '.join(solution.disagreeing)}"))
    if known is not None and known.undetermined:
        said.append(("", f"not determined by these images: {short_list(known.undetermined, '; ')}"))
    if solution.expected is not None:
        said.append(("expect", str(solution.expected)))
    if solution.accepted:
        said.append(_depth_before(solution))
    return said


def _depth_before(solution: AbstractResult) -> tuple[str, str]:
    """What the repair says of the depth of the initial calibration."""
    seen = solution.estimate
    if solution.decision is not None and solution.decision.keeps_depth:
        if seen is not None and seen.windows:
            return (
                "depth",
                "stays as it was calibrated: neither the epipolar error nor the rig's motion determine it better",
            )
        return (
            "depth",
            "stays as it was calibrated: the epipolar error does not determine it; frames taken while the rig moves, "
            "or ranges, would",
        )
    if seen is None:
        return "", f"depth was off: {depths(solution.depth_error_percent)}"
    errors = seen.depth_error_percent(np.zeros(len(seen.names)))
    ends = {d: dict.fromkeys(change(end, "far") for end in (low, high)) for d, (_, low, high) in errors.items()}
    return "", "depth was off: " + ", ".join(f"{' to '.join(both)} at {d} B" for d, both in ends.items())


def _misfit(solution: AbstractResult, left: Misfit) -> str | None:
    """What is worth saying of the misfit."""
    if left.cause is Cause.RADIAL and left.alike > _SYSTEMATIC:
        said = f"the intrinsics do not fit: {left.alike:.2f} px of the epipolar error are systematic"
        return said if solution.intrinsics is not None else f"{said}; {_WOULD_TELL}"
    if left.high > WORTH_SAYING or solution.reason is Reason.MISFIT:
        return f"{left.high:.2f} px in the worst tenth of the regions; {left.cause.value}"
    return None
