"""A solution as lines of text."""

from stereorecal.recalibration._facts import changed_axes, facts_of
from stereorecal.recalibration._result import AbstractResult
from stereorecal.report.repair_report import Change


def repair_text(solution: AbstractResult) -> str:
    """All that is printed of it."""
    rows = solution.row_errors
    before, after = ("", "") if rows is None else (f", row error {px:.2f} px" for px in (rows.before, rows.after))
    lines = [
        solution.verdict,
        solution.advice,
        _line("search", f"{solution.message} ({solution.evaluations} evaluations, {solution.seconds:.1f} s)"),
        _line("before", f"{solution.score_before}{before}"),
        _line("after", f"{solution.score_after}{after}"),
        *map(_axis, changed_axes(solution)),
        *(_line(fact.heading, fact.text) for fact in facts_of(solution) if fact.text),
    ]
    return "\n".join(lines)


def _line(heading: str, text: str) -> str:
    return f"{heading:<8} {text}" if heading else text


def _axis(axis: Change) -> str:
    unit = "deg" if axis.unit == "°" else axis.unit
    line = f"{axis.name:<6} {axis.before:+9.3f} -> {axis.after:+9.3f} {unit:<3} changed by {axis.change:+8.3f}"
    return line if axis.half_width is None else f"{line} ± {axis.half_width:.3f}"
