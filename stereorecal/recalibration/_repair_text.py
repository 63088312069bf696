"""A solution as lines of text."""

from collections.abc import Iterator

from stereorecal.recalibration._facts import changed_axes, facts_of
from stereorecal.recalibration._result import AbstractResult
from stereorecal.report.number_text import count
from stereorecal.report.repair_report import Change

_FIRST = ("matchers", "depth", "depth kept")  # remarks above the axes


def repair_text(solution: AbstractResult) -> str:
    """All that is printed of it; of a candidate that was not taken, only why."""
    facts = [fact for fact in facts_of(solution) if fact.text]
    lines = [
        solution.verdict,
        solution.advice,
        _line("matched", _matched(solution)),
        *_epipolar(solution),
        *(_line(fact.heading, fact.text) for fact in facts if fact.about in _FIRST),
        *(map(_axis, changed_axes(solution)) if solution.accepted else ()),
        *(_line(fact.heading, fact.text) for fact in facts if fact.about not in _FIRST),
    ]
    if solution.searched:
        how = f"{solution.message} ({solution.evaluations} evaluations, {solution.seconds:.1f} s)"
        lines.append(_line("search", how))
    return "\n".join(lines)


def _matched(solution: AbstractResult) -> str:
    """The count, and how far the rows of matches differ; before and after a repair."""
    before, after, rows = solution.score_before, solution.score_after, solution.row_errors
    if not solution.accepted:
        differ = "" if rows is None else f"; their rows differ by {rows.before:.2f} px in the median"
        return f"{before}{differ}"
    counts = f"{count(before.count)} -> {count(after.count)} of {count(before.pixels)} pixels"
    shares = f"{100 * before.fraction:.1f} -> {100 * after.fraction:.1f} %"
    differ = "" if rows is None else f"; their rows differ by {rows.before:.2f} -> {rows.after:.2f} px in the median"
    return f"{counts} ({shares}){differ}"


def _epipolar(solution: AbstractResult) -> Iterator[str]:
    """The epipolar error, of the calibration to use with its interval."""
    if solution.decision is None or not solution.reason.healthy:
        return
    rows = solution.decision.rows_px
    value, low, high = rows[int(solution.accepted)]
    before = f"{rows[0, 0]:.2f} -> " if solution.accepted else ""
    yield _line("epipolar", f"{before}{value:.2f} px ({low:.2f} to {high:.2f}) where the images show something")


def _line(heading: str, text: str) -> str:
    return f"{heading:<8} {text}" if heading else text


def _axis(axis: Change) -> str:
    unit = "deg" if axis.unit == "°" else axis.unit
    line = f"{axis.name:<8} {axis.before:+z9.3f} -> {axis.after:+z9.3f} {unit:<3} changed by {axis.change:+z8.3f}"
    return line if axis.half_width is None else f"{line} ± {axis.half_width:.3f}"
