"""A repair as a self-contained HTML page: what to do, and where in the image depth can be trusted.

Needs jinja2 and matplotlib: pip install 'stereorecal[figures]'.
"""

from pathlib import Path

from stereorecal.report._embedded_images import colour_bar, data_uri, disparity_picture, rows_picture
from stereorecal.report._regions import misaligned, where
from stereorecal.report._repair_figures import expected_figure, field_figures, histogram_figure
from stereorecal.report.disparity_map import colour_range
from stereorecal.report.repair_report import RepairReport
from stereorecal.report.templates import Markup, rendered

_WIDE, _NARROW = 720, 560  # pixels: of one image of a rectified pair, of a disparity map
_SCRIPT = Path(__file__).with_name("slider.js")


def repair_page(report: RepairReport) -> str:
    """The page as HTML text, at most some hundred kilobytes for images of any size; names are escaped."""
    sights = (report.before, report.after)
    maps = [(sight.disparity, sight.valid) for sight in sights]
    least, largest = colour_range(maps)
    return rendered(
        "repair.html.jinja",
        report=report,
        conclusion=report.conclusion.name.lower(),
        where=where(report),
        names=report.names,
        pairs=[data_uri(rows_picture(sight.left, sight.right, _WIDE)) for sight in sights],
        disparities=[data_uri(disparity_picture(*one, least, largest, _NARROW)) for one in maps],
        shares=[float(sight.valid.mean()) for sight in sights],
        bar=colour_bar(least, largest),
        figures=_figures(report),
        used=sum(state == "used" for _, state, _ in report.frames),
        script=_SCRIPT,
    )


def _figures(report: RepairReport) -> dict[str, list[Markup]]:
    """SVG elements, by what they show; none where there is nothing to draw."""
    drawn: dict[str, list[str]] = {}
    if report.rows is not None:
        left = report.misfit
        places = ([], []) if left is None else (misaligned(left, "before"), misaligned(left, "after"))
        drawn["field"] = field_figures(report.rows, report.after.left, report.names, places)
        drawn["histogram"] = [histogram_figure(report.rows, report.names)]
    if report.expected is not None:
        used = report.after if report.accepted else report.before
        drawn["expected"] = [expected_figure(report.expected, used.left)]
    return {name: [Markup(figure) for figure in figures] for name, figures in drawn.items()}
