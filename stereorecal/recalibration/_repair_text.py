"""A solution as the plain data of its lines of text."""

import numpy as np

from stereorecal.decision import Reason
from stereorecal.estimation import DEFAULT, EXACT
from stereorecal.geometry import AXES, PINHOLE
from stereorecal.objectives import BASELINE
from stereorecal.recalibration._motion_report import motion_text, odometer_text
from stereorecal.recalibration._regional_misfit import WORTH_SAYING, Cause, Misfit
from stereorecal.recalibration._result import AbstractResult
from stereorecal.report.number_text import change, depths
from stereorecal.report.repair_report import Axis
from stereorecal.report.repair_text import RepairText
from stereorecal.report.short_list import short_list

EPIPOLAR_ERROR_LEFT = (
    "more epipolar error remains than good calibrations have: other intrinsics (were these images rectified already?), "
    "or something that moved"
)
_SYSTEMATIC = 0.05  # pixels of radial misfit that regions share; right intrinsics leave 0.01


def text_of(solution: AbstractResult) -> RepairText:
    """All that is printed of a solution."""
    rows = solution.row_errors
    before, after = ("", "") if rows is None else (f", row error {px:.2f} px" for px in (rows.before, rows.after))
    return RepairText(
        verdict=solution.verdict,
        advice=solution.advice,
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
    lines, estimate, use, known = [], solution.estimate, solution.prior_use, solution.uncertainty
    if solution.view.projection != PINHOLE:
        lines.append(("view", str(solution.view)))
    lines += [("check", doubt) for doubt in solution.doubts]
    if use is not None and str(use) not in (DEFAULT, EXACT):
        lines.append(("prior", str(use)))
    if solution.misfit is not None and (misfit := _misfit(solution, solution.misfit)):
        lines.append(("misfit", misfit))
    if solution.intrinsics is not None:
        lines.append(("", str(solution.intrinsics)))
    if solution.ranges is not None:
        lines.append(("ranges", str(solution.ranges)))
    if estimate is not None and estimate.windows:
        lines.append(("motion", motion_text(estimate)))
    if estimate is not None and solution.settings.odometer is not None:
        lines.append(("odometer", odometer_text(estimate)))
    if solution.left_out:
        lines.append(("", f"left out, since they disagree with the others: {', '.join(solution.left_out)}"))
    if solution.disagreeing:
        lines.append(("", f"these disagree with others: {', '.join(solution.disagreeing)}"))
    if known is not None and known.undetermined:
        lines.append(("", f"not determined by these images: {short_list(known.undetermined, '; ')}"))
    if solution.expected is not None:
        lines += [("expect", str(solution.expected)), *_view(solution)]
    if solution.leaves_epipolar_error:
        lines.append(("check", EPIPOLAR_ERROR_LEFT))
    if solution.accepted:
        lines.append(_depth_before(solution))
    return lines


def _depth_before(solution: AbstractResult) -> tuple[str, str]:
    """What the repair says of the depth of the initial calibration."""
    estimate = solution.estimate
    if solution.decision is not None and solution.decision.depth_corrected < 1.0:
        how = "is corrected as far as is safe" if solution.decision.depth_corrected else "stays as it was calibrated"
        return "depth", f"{how}; frames in motion, or ranges, determine it"
    if estimate is None:
        return "", f"depth was off: {depths(solution.depth_error_percent)}"
    errors = estimate.depth_error_percent(np.zeros(len(estimate.names)))
    ends = {d: dict.fromkeys(change(end, "far") for end in (low, high)) for d, (_, low, high) in errors.items()}
    return "", "depth was off: " + ", ".join(f"{' to '.join(both)} at {d} B" for d, both in ends.items())


def _view(solution: AbstractResult) -> list[tuple[str, str]]:
    """What is extrapolated to where nothing matched, if it matters."""
    if solution.decision is None or not solution.reason.healthy:
        return []
    shown, view = (px[int(solution.accepted), 0] for px in (solution.decision.rows_px, solution.decision.view_px))
    if view <= max(2.0 * shown, solution.tolerances.good_rows_px):
        return []
    return [("corners", f"row error {view:.2f} px over the whole view, most of it where nothing matched")]


def _misfit(solution: AbstractResult, misfit: Misfit) -> str | None:
    """What is worth saying of the misfit."""
    if misfit.cause is Cause.RADIAL and misfit.alike > _SYSTEMATIC:
        return f"the lens model does not fit; {misfit.alike:.2f} px of the epipolar error are systematic"
    if misfit.high > WORTH_SAYING or solution.reason is Reason.MISFIT:
        return f"a tenth of the regions are off by more than {misfit.high:.2f} px; {misfit.cause.value}"
    return None
