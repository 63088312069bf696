"""A repair as lines of text, from plain data."""

from collections.abc import Sequence
from dataclasses import dataclass

from stereorecal.report.repair_report import Axis


@dataclass(frozen=True)
class RepairText:
    """What the lines say.

    Attributes:
        verdict, advice, search: in words.
        before, after: what matches under both calibrations, and its row error.
        axes: of the extrinsics, angles in degrees, lengths in millimetres.
        remarks: what else is to be said; with a heading, or whole sentences without.
    """

    verdict: str
    advice: str
    search: str
    before: str
    after: str
    axes: Sequence[Axis]
    remarks: Sequence[tuple[str, str]]


def repair_text(text: RepairText) -> str:
    """The lines."""
    headed = [
        ("", text.verdict),
        ("", text.advice),
        ("search", text.search),
        ("before", text.before),
        ("after", text.after),
    ]
    lines = [*map(_line, headed), *map(_axis, text.axes), *map(_line, text.remarks)]
    return "\n".join(lines)


def _line(remark: tuple[str, str]) -> str:
    heading, text = remark
    return f"{heading:<8} {text}" if heading else text


def _axis(axis: Axis) -> str:
    unit = "deg" if axis.unit == "°" else axis.unit
    line = f"{axis.name:<6} {axis.before:+9.3f} -> {axis.after:+9.3f} {unit:<3} changed by {axis.change:+8.3f}"
    return line if axis.half_width is None else f"{line} ± {axis.half_width:.3f}"
