"""The field's table as a self-contained HTML page to publish: a table that sorts, and three figures.

Needs jinja2 and matplotlib: pip install 'stereorecal[figures]'.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereorecal.report.templates import Markup, rendered
from stereorecal_field.table._field_figures import coverage, error_against_seconds, harm, letters_of
from stereorecal_field.table._field_tables import before_and_after, depth_at, panel_of, troubles

_SCRIPT = Path(__file__).with_name("sorting.js")


def field_page(data: Mapping[str, Any]) -> str:
    """The page as HTML text; names and messages are escaped.

    Args:
        data: of the table's JSON.
    """
    summary = data["summary"]
    covered = coverage(data) if summary else None
    return rendered(
        Path(__file__).with_name("field.html.jinja"),
        data=data,
        letters=letters_of(data),
        seconds=Markup(error_against_seconds(data)) if summary else None,
        coverage=Markup(covered) if covered else None,
        harm=Markup(harm(data)) if any(row["trials"] for row in summary) else None,
        troubles=troubles(data),
        before_and_after=before_and_after,
        depth_at=depth_at,
        panel_of=panel_of,
        script=_SCRIPT,
    )
