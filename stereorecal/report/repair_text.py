"""A repair as lines of text, from plain data."""

from collections.abc import Sequence
from dataclasses import dataclass

from stereorecal.report.repair_report import Axis


@dataclass(frozen=True)
class RepairText:
    """What the lines say.

    Attributes:
        verdict, search: in words.
        before, after: what matches under both calibrations, and its row error.
        axes: of the extrinsics, angles in degrees, lengths in millimetres.
        remarks: what else is to be said; with a heading, or whole sentences without.
    """

    verdict: str
    search: str
    before: str
    after: str
    axes: Sequence[Axis]
    remarks: Sequence[tuple[str, str]]


def repair_text(said: RepairText) -> str:
    """The lines."""
    headed = [("", said.verdict), ("search", said.search), ("before", said.before), ("after", said.after)]
    lines = [*map(_line, headed), *map(_axis, said.axes), *map(_line, said.remarks)]
    return "\n".join(lines)


def _line(remark: tuple[str, str]) -> str:
    heading, text = remark
    return f"{heading:<8} {text}" if heading else text


def _axis(axis: Axis) -> str:
    unit = "deg" if axis.unit == "°" else axis.unit
    line = f"{axis.name:<6} {axis.before:+9.3f} -> {axis.after:+9.3f} {unit:<3} changed by {axis.change:+8.3f}"
    return line if axis.half_width is None else f"{line} ± {axis.half_width:.3f}"
