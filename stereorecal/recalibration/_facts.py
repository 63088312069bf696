"""What there is to say of a solution: said here once, for all that print it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.decision import Reason
from stereorecal.estimation import DEFAULT, EXACT
from stereorecal.geometry import AXES, PINHOLE, intrinsic
from stereorecal.objectives import BASELINE
from stereorecal.recalibration._motion_windows import motion_text, odometer_text
from stereorecal.recalibration._result import AbstractResult, DepthOutcome, depth_outcome
from stereorecal.recalibration._row_residuals import WORTH_SAYING
from stereorecal.report.number_text import count, short_list
from stereorecal.report.repair_report import Change

# Too little was seen, or judged, for the candidate to mean anything: what its axes are would be read as an answer.
NOTHING_SEEN = (Reason.TOO_LITTLE_TEXTURE, Reason.OUT_OF_BUDGET)
SAYS_NOTHING = (*NOTHING_SEEN, Reason.NO_MATCHES)  # images that show enough would match under a good calibration
_NETWORKS = 2.0  # pixels: stereo networks ask for less (S2M2; Min et al. 2025)
_AT = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # pixels; below, block matching finds as much, and SGM as much that is right
_LOST = (0.0, 4.0, 11.0, 30.0, 45.0, 59.0)  # percent of the pixels of StereoBM
_WRONG = (0.0, 1.0, 3.0, 9.0, 18.0, 37.0)  # percent of the pixels of StereoSGBM that are off by more than 2 px
_LATE = "the two images of a pair are not taken at the same time"
_REGIONS = "regions differ in epipolar error: something moved between the two exposures, or the intrinsics do not fit"
_EPIPOLAR_ERROR_LEFT = (
    "more epipolar error remains than good calibrations have: other intrinsics (were these images rectified already?), "
    "or something that moved"
)
_LEFT = {DepthOutcome.KEPT: "kept as it was calibrated", DepthOutcome.IN_PART: "corrected as far as is safe"}
_CALLED = {"f": "focal length, f", "cx": "centre, cx", "cy": "centre, cy", "aspect": "aspect, fy / fx"}


def matcher_loss(rows: Float[np.ndarray, "p"], weights: Float[np.ndarray, "p"]) -> str:
    """What epipolar errors cost block matching, semi-global matching and networks, as measured on Middlebury's
    motorcycle with shifted rows (tests/benchmarks/matcher_loss.py): rows in pixels at full size, with weights that sum
    to 1."""
    lost, wrong = (float(weights @ np.interp(np.abs(rows), _AT, values)) for values in (_LOST, _WRONG))
    if lost < 1.0:
        return "hardly a pixel lost"
    if weights @ np.abs(rows) > _AT[-1]:
        return f"block matching loses most of its pixels; stereo networks need less than {_NETWORKS:g} px"
    text = f"block matching loses about {lost:.0f} % of its pixels, SGM gets {wrong:.0f} % wrong"
    return text if weights @ np.abs(rows) < _NETWORKS else f"{text}; stereo networks need less than {_NETWORKS:g} px"


@dataclass(frozen=True)
class Fact:
    """One thing to say of a solution.

    Attributes:
        heading: of its line; "": none.
        text: what is said.
        remark: whether a page says it in words, since no table or figure shows it.
    """

    heading: str
    text: str
    remark: bool = False

    def __str__(self) -> str:
        return f"{self.heading:<8} {self.text}" if self.heading else self.text

    @property
    def sentence(self) -> str:
        """As a page has it."""
        text = f"{self.heading}: {self.text}" if self.heading else self.text
        return f"{text[:1].upper()}{text[1:]}."


def repair_text(solution: AbstractResult) -> str:
    """All that is printed of it; of a candidate that was not taken, only why."""
    return "\n".join([solution.verdict, solution.advice, *map(str, facts_of(solution))])


def facts_of(solution: AbstractResult) -> Iterator[Fact]:
    """All that there is to say beside the verdict and what to do, in the order in which texts and pages have it."""
    estimate, use, known = solution.estimate, solution.prior_use, solution.uncertainty
    telling = solution.reason not in SAYS_NOTHING
    yield Fact("matched", _matched(solution))
    yield from _epipolar(solution)
    yield from _matchers(solution)
    yield from _depth(solution)
    changed = "changed by" if solution.searched else "would change by"
    yield from (_axis(axis, changed) for axis in changed_axes(solution)) if solution.accepted else ()
    if solution.view.projection != PINHOLE:
        yield Fact("view", str(solution.view))
    for doubt in solution.doubts:
        yield Fact("check", doubt)
    if use is not None and str(use) not in (DEFAULT, EXACT):
        yield Fact("prior", str(use), remark=True)
    if telling:
        yield from _misfit(solution)
    if solution.intrinsics is not None:
        text = str(solution.intrinsics)
        if solution.intrinsics.changed and solution.searched:  # a look has neither the option nor new values to use
            text = f"{text}; use all new values together (--free extrinsics keeps the intrinsics, and may find less)"
        yield Fact("", text, remark=True)
    if solution.ranges is not None:
        yield Fact("ranges", str(solution.ranges), remark=True)
    if estimate is not None and estimate.windows:
        yield Fact("motion", motion_text(estimate), remark=True)
    if estimate is not None and solution.settings.odometer is not None:
        yield Fact("odometer", odometer_text(estimate), remark=True)
    if solution.left_out:
        yield Fact("", f"left out, since they disagree with the others: {', '.join(solution.left_out)}", remark=True)
    if solution.disagreeing:
        yield Fact("", f"these disagree with others: {', '.join(solution.disagreeing)}")
    if known is not None and known.undetermined and telling:
        names = short_list(known.undetermined, "; ")
        yield Fact("", f"not determined by these images, and assumed to have changed little: {names}", remark=True)
    yield from _corners(solution)
    if solution.leaves_epipolar_error:
        yield Fact("check", _EPIPOLAR_ERROR_LEFT, remark=True)
    if solution.searched:
        yield Fact("search", f"{solution.message} ({solution.evaluations} evaluations, {solution.seconds:.1f} s)")


def _matched(solution: AbstractResult) -> str:
    """The count, and how far the rows of matches differ; before and after a repair."""
    before, after, rows = solution.score_before, solution.score_after, solution.row_errors
    if solution.reason in SAYS_NOTHING:
        rows = None  # chance matches lie on the rows that they were searched on
    if not solution.accepted:
        differ = "" if rows is None else f"; their rows differ by {rows.before:.2f} px in the median"
        return f"{before}{differ}"
    counts = f"{count(before.count)} -> {count(after.count)} of {count(before.pixels)} pixels"
    shares = f"{100 * before.fraction:.1f} -> {100 * after.fraction:.1f} %"
    differ = "" if rows is None else f"; their rows differ by {rows.before:.2f} -> {rows.after:.2f} px in the median"
    return f"{counts} ({shares}){differ}"


def _epipolar(solution: AbstractResult) -> Iterator[Fact]:
    """The epipolar error, of the calibration to use with its interval."""
    if solution.decision is None or not solution.reason.healthy:
        return
    rows = solution.decision.rows_px
    value, low, high = rows[int(solution.accepted)]
    before = f"{rows[0, 0]:.2f} -> " if solution.accepted else ""
    yield Fact("epipolar", f"{before}{value:.2f} px ({low:.2f} to {high:.2f}) where the images show something")


def _axis(axis: Change, changed: str) -> Fact:
    unit = "deg" if axis.unit == "°" else axis.unit
    text = f"{axis.before:+z9.3f} -> {axis.after:+z9.3f} {unit:<3} {changed} {axis.change:+z8.3f}"
    return Fact(axis.name, text if axis.half_width is None else f"{text} ± {axis.half_width:.3f}")


def _misfit(solution: AbstractResult) -> Iterator[Fact]:
    """What is worth saying of the misfit."""
    misfit = solution.misfit
    if misfit is None:
        return
    if misfit.high > WORTH_SAYING or solution.reason is Reason.MISFIT:
        text = f"a tenth of the regions are off by more than {misfit.high:.2f} px; {_LATE if misfit.late else _REGIONS}"
        whose = "" if solution.accepted else " (under the candidate, which was not taken)"
        yield Fact("misfit", f"{text}{whose}", remark=True)


def _corners(solution: AbstractResult) -> Iterator[Fact]:
    """What is extrapolated to where nothing matched, if it matters."""
    if solution.expected is None or solution.decision is None:
        return
    shown, view = (px[int(solution.accepted), 0] for px in (solution.decision.rows_px, solution.decision.view_px))
    if view > max(2.0 * shown, solution.settings.tolerances.good_rows_px):
        yield Fact("corners", f"epipolar error {view:.2f} px over the whole view, most of it where nothing matched")


def _depth(solution: AbstractResult) -> Iterator[Fact]:
    """The errors of depth, before a repair and after."""
    for before, after in zip(solution.depth_before, solution.depth, strict=True):
        change = f"{before}, {_when(solution)} {after}" if solution.accepted else str(after)
        yield Fact("depth", f"error at {after.where} {change}")
    if not solution.accepted:
        return
    how = None if solution.decision is None else _LEFT.get(depth_outcome(solution, solution.decision))
    if how is not None:
        yield Fact("depth", f"{how}; frames in motion, or ranges, determine it")
    if solution.estimate is None:
        yield Fact("depth", f"was off: {solution.difference.depth_text}")


def _matchers(solution: AbstractResult) -> Iterator[Fact]:
    """What the epipolar error means to matchers."""
    estimate = solution.estimate
    if estimate is None or not solution.reason.healthy:
        return
    both = (estimate.chart.coordinates_of(rig) for rig in (solution.initial, solution.rig))
    told = dict.fromkeys(matcher_loss(*estimate.rows_seen(theta)) for theta in both)
    yield Fact("matchers", f"; {_when(solution)} ".join(told))


def _when(solution: AbstractResult) -> str:
    """When the candidate is in use: a look changes nothing."""
    return "now" if solution.searched else "then"


def changed_axes(solution: AbstractResult) -> list[Change]:
    """The change of each of the extrinsics, in degrees and millimetres; its interval only where the rig to use is good:
    else it would be that of an answer that was found wrong."""
    known, changes = solution.uncertainty, solution.change
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
        found.append(Change(name, unit, before, factor * float(changes[index]), half_width, observed))
    return found


def changed_intrinsics(solution: AbstractResult) -> list[tuple[str, Change]]:
    """The camera and the change of each intrinsic parameter, in units of a calibration file, if they were taken; else
    none: then they stay, and are no answer."""
    intrinsics, found = solution.intrinsics, []
    if intrinsics is None or not intrinsics.taken:
        return []
    for full, wide in zip(intrinsics.names, intrinsics.interval.tolist(), strict=True):
        camera, _, name = full.partition(".")
        if not name:
            continue  # the baseline, which is an axis of the rig
        before, after = (intrinsic(getattr(rig, camera), name) for rig in (solution.initial, solution.candidate))
        half_width = wide / 100.0 * after if name in ("f", "aspect") else wide
        unit, digits = ("px", 2) if name in ("f", "cx", "cy") else ("", 5)
        observed = full not in intrinsics.undetermined
        called = _CALLED.get(name, name)
        found.append((camera, Change(called, unit, before, after - before, half_width, observed, digits)))
    return found
