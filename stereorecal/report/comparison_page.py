"""A comparison as a self-contained HTML page, which also prints and reads well on a phone.

Needs jinja2 and matplotlib: pip install 'stereorecal[figures]'.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from stereorecal.report._comparison_figures import Series, curve_figures, lines_of, strips
from stereorecal.report._embedded_images import colour_bar, data_uri, disparity_picture
from stereorecal.report.comparison_tables import REFERENCES, schedules_legend, strategies_of, title_of
from stereorecal.report.disparity_map import TrialPicture, colour_range
from stereorecal.report.templates import Markup, flat_settings, rendered

_WIDE = 420  # pixels, of a disparity map
_LEAST_ERROR = 1e-4  # degrees; smaller errors are drawn here, since a logarithmic axis has no zero

Row = Mapping[str, Any]


def comparison_page(data: Mapping[str, Any], profile: Sequence[Row] = (), pictures: Sequence[TrialPicture] = ()) -> str:
    """The page as HTML text, of a comparison's JSON, the curves of its data profile as plain data, and pictures of some
    trials; names and messages are escaped."""
    data = {**data, "summary": sorted(data["summary"], key=lambda row: _rank(row, data))}
    return rendered(
        "comparison.html.jinja",
        data=data,
        figures={scene: panels for scene in _names(data, "scene") if (panels := _panels(data, scene))},
        curves=_curves(data, profile),
        pictures=_pictures(pictures),
        marks=_marks(data),
        best=_best(data),
        troubles=_troubles(data),
        settings=_settings_rows(data),
        references=REFERENCES,
        schedules=schedules_legend(data),
        planned=len(data["scenes"]) * data["settings"]["draws"] * len(data["settings"]["entrants"]),
        strategies_of=strategies_of,
    )


def _rank(row: Row, data: Mapping[str, Any]) -> tuple[int, float, float]:
    """Scenes as they were given; in each the entrant with the most successes first, then the one with the best r."""
    scenes = [scene["name"] for scene in data["scenes"]]
    return scenes.index(row["scene"]), -(row["success_rate"] or 0.0), -(row["ratio_median"] or 0.0)


def _curves(data: Mapping[str, Any], profile: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """The curves of each scene, with their legend."""
    free = {(row["scene"], title_of(row, data)) for row in data["summary"] if row["cost_median"] == 0.0}
    found = {}
    for scene in dict.fromkeys(row["scene"] for row in profile):
        rows = [row for row in profile if row["scene"] == scene]
        titles = [title_of(row, data) for row in rows]
        lines = lines_of([title + ", no units spent" * ((scene, title) in free) for title in titles])
        found[scene] = {"lines": lines, "panels": [Markup(panel) for panel in curve_figures(rows, lines)]}
    return found


def _pictures(pictures: Sequence[TrialPicture]) -> dict[str, dict[str, Any]]:
    """The pictures of each scene, on one scale, with that scale: the title of each trial, and what it shows."""
    found = {}
    for scene in dict.fromkeys(one.scene for one in pictures):
        trials = [one for one in pictures if one.scene == scene]
        least, largest = colour_range(maps for one in trials for maps in (one.before, one.after))
        shown = {
            one.title: {
                when: (data_uri(disparity_picture(*maps, least, largest, _WIDE)), float(maps[1].mean()))
                for when, maps in (("before", one.before), ("after", one.after))
            }
            for one in trials
        }
        found[scene] = {"bar": colour_bar(least, largest), "trials": shown}
    return found


def _names(data: Mapping[str, Any], kind: str) -> list[str]:
    return list(dict.fromkeys(row[kind] for row in data["summary"]))


def _panels(data: Mapping[str, Any], scene: str) -> list[Markup]:
    """The charts of one scene for the page."""
    limits = data["settings"]["thresholds"]
    names = list(dict.fromkeys(title_of(row, data) for row in data["summary"]))
    finished = [row for row in data["trials"] if row["scene"] == scene and row["ratio"] is not None]
    if not finished:
        return []
    trials = [[row for row in finished if title_of(row, data) == name] for name in names]
    ratio = Series("r", [[row["ratio"] for row in rows] for rows in trials])
    errors = [
        Series(axis, [[max(row["rotation_error_deg"][axis], _LEAST_ERROR) for row in rows] for rows in trials])
        for axis in ("pitch", "yaw", "roll")
    ]
    panels = [
        strips(names, [ratio], "r = N_o / N_GT", (limits["ratio"], limits["flagged_ratio"]), log=False, tall=3),
        strips(names, errors, "rotation error [°]", (limits["pitch_roll_deg"], limits["yaw_deg"]), log=True),
    ]
    reached = [
        Series(f"{units} units", [_score_at(data, scene, name, units) for name in names]) for units in _marks(data)
    ]
    if any(value for series in reached for value in series.values):
        panels.append(strips(names, reached, "best score (median)", (), log=False, tall=3))
    return [Markup(panel) for panel in panels]


def _marks(data: Mapping[str, Any]) -> list[str]:
    """The budgets in units, within that of the comparison, at which the best score was recorded."""
    budget = data["settings"]["budget"]["evaluations"] or float("inf")
    marks = data["summary"][0]["score_at_median"] if data["summary"] else ()
    return [units for units in marks if float(units) <= budget]


def _score_at(data: Mapping[str, Any], scene: str, name: str, units: str) -> list[float]:
    rows = (row for row in data["summary"] if (row["scene"], title_of(row, data)) == (scene, name))
    return [value for row in rows if (value := row["score_at_median"][units]) is not None]


def _best(data: Mapping[str, Any]) -> dict[tuple[str, str], float]:
    """The highest median score of each scene at each budget."""
    best: dict[tuple[str, str], float] = {}
    for row in data["summary"]:
        for units, value in row["score_at_median"].items():
            if value is not None:
                best[row["scene"], units] = max(value, best.get((row["scene"], units), value))
    return best


def _troubles(data: Mapping[str, Any]) -> dict[tuple[str, str, str], int]:
    """Number of trials that were skipped or failed, by entrant, status and message."""
    troubles: dict[tuple[str, str, str], int] = {}
    for row in data["trials"]:
        if row["status"] in ("SKIPPED", "FAILED"):
            key = title_of(row, data), row["status"], row["message"]
            troubles[key] = troubles.get(key, 0) + 1
    return troubles


def _settings_rows(data: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The settings by name, with the strategies of each entrant in full."""
    settings = dict(data["settings"])
    entrants = {
        f"schedule {one['schedule']}, {one['strategy']}": strategies_of(one) for one in settings.pop("entrants")
    }
    return list(flat_settings({**settings, **entrants, **data["versions"]}))
