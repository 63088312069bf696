"""A repair as a self-contained HTML page: what to do, and where in the image depth can be trusted.

Needs jinja2 and matplotlib: pip install 'stereorecal[figures]'.
"""

import base64
import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from stereorecal.report._pictures import data_uri, disparity_picture, rows_picture
from stereorecal.report._regions import spoiled, where_not
from stereorecal.report._repair_figures import expected_figure, field_figure, histogram_figure, progress_figure
from stereorecal.report._templates import Markup, rendered
from stereorecal.report.disparity import colour_range
from stereorecal.report.repair import RepairReport

_WIDE, _NARROW = 720, 560  # pixels: of one image of a rectified pair, of a disparity map
_SCRIPT = Path(__file__).with_name("slider.js")


def repair_page(report: RepairReport) -> str:
    """The page as HTML text, at most some hundred kilobytes for images of any size; names are escaped."""
    after = "after" if report.accepted else "candidate"
    sights = {"before": report.before, after: report.after}
    shown = [(sight.disparity, sight.valid) for sight in sights.values()]
    least, largest = colour_range(shown)
    script = _SCRIPT.read_text(encoding="utf-8")
    return rendered(
        "repair.html.jinja",
        report=report,
        headline=headline(report),
        where=None if report.misfit is None else where_not(report.misfit),
        pairs={name: data_uri(rows_picture(sight.left, sight.right, _WIDE)) for name, sight in sights.items()},
        disparities={
            name: data_uri(disparity_picture(sight.disparity, sight.valid, least, largest, _NARROW))
            for name, sight in sights.items()
        },
        shares={name: float(sight.valid.mean()) for name, sight in sights.items()},
        least=least,
        largest=largest,
        figures=_figures(report, after),
        after_name=after,
        used=sum(state == "used" for _, state, _ in report.frames),
        settings=list(_flat(report.settings)),
        calibrations={title: json.dumps(content, indent=1) for title, content in report.calibrations.items()},
        script=Markup(script),
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii"),
    )


def headline(report: RepairReport) -> str:
    """What to do, in a sentence."""
    if not report.healthy:
        return "Do not trust either calibration yet"
    best = "Use the new calibration" if report.accepted else "Keep the calibration that you have"
    return f"{best}, but not everywhere" if report.misfit is not None and spoiled(report.misfit) else best


def _figures(report: RepairReport, after: str) -> dict[str, Markup]:
    """SVG elements, by what they show; those that there is something to draw for."""
    image = report.after.left
    drawn = {
        "field": report.rows and field_figure(report.rows, image, after),
        "histogram": report.rows and histogram_figure(report.rows, after),
        "expected": None if report.expected is None else expected_figure(report.expected, image),
        "progress": progress_figure(report.climbs, report.way),
    }
    return {name: Markup(figure) for name, figure in drawn.items() if figure}


def _flat(settings: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Nested settings as a flat list of names, such as "matcher block_size", and values."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{above}{key} ")
        else:
            text = "; ".join(map(str, value)) if isinstance(value, list) else "-" if value is None else str(value)
            yield above + key, text
