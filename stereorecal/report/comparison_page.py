"""A comparison as a self-contained HTML page, which also prints and reads well on a phone.

Needs jinja2 and matplotlib: pip install 'stereorecal[figures]'.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from stereorecal.report._comparison_figures import curve_figures, strips
from stereorecal.report._embedded_images import colour_bar, data_uri, disparity_picture
from stereorecal.report.comparison_tables import (
    TRIALS,
    WORDS,
    rows_by_title,
    several_schedules,
    terms,
    title_of,
    troubles,
)
from stereorecal.report.disparity_map import TrialPicture, colour_range
from stereorecal.report.number_text import number
from stereorecal.report.templates import Markup, rendered

_WIDE = 420  # pixels, of a disparity map
_LEAST_ERROR = 1e-4  # degrees; smaller errors are drawn here, since a logarithmic axis has no zero

Row = Mapping[str, Any]


def comparison_page(data: Mapping[str, Any], profile: Sequence[Row] = (), pictures: Sequence[TrialPicture] = ()) -> str:
    """The page as HTML text, of a comparison's JSON, the curves of its data profile as plain data, and pictures of some
    trials; names and messages are escaped."""
    scenes = [scene["name"] for scene in data["scenes"]]

    def rank(row: Row) -> tuple[int, float, float]:
        """The place of a row: scenes as they were given, in each the most successes first, then the best r."""
        return scenes.index(row["scene"]), -(row["success_rate"] or 0.0), -(row["ratio_median"] or 0.0)

    data = {**data, "summary": sorted(data["summary"], key=rank)}
    tables = rows_by_title(data)
    return rendered(
        "comparison.html.jinja",
        data=data,
        figures={scene: panels for scene in scenes if (panels := _panels(data, scene))},
        curves=_curves(data, profile),
        pictures=_pictures(pictures),
        trials=tables.pop(TRIALS),
        tables=tables,
        scenes=[_scene(scene) for scene in data["scenes"]],
        words=WORDS,
        troubles=troubles(data),
        terms=terms(data),
        several_schedules=several_schedules(data),
        planned=len(data["scenes"]) * data["settings"]["draws"] * len(data["settings"]["entrants"]),
    )


def _scene(scene: Row) -> dict[str, str]:
    """The row of a scene."""
    first = scene["min_disparity"]
    return {
        "scene": scene["name"],
        "size": "x".join(map(str, scene["image_size"])),
        "frames": str(scene["frames"]),
        "baseline [m]": number(scene["baseline_m"], 3),
        "disparities": f"{first} to {first + scene['num_disparities']}",
    }


def _curves(data: Mapping[str, Any], profile: Sequence[Row]) -> dict[str, list[Markup]]:
    """The curves of each scene."""
    free = {(row["scene"], title_of(row, data)) for row in data["summary"] if row["cost_median"] == 0.0}
    found = {}
    for scene in dict.fromkeys(row["scene"] for row in profile):
        rows = [row for row in profile if row["scene"] == scene]
        titles = [title_of(row, data) for row in rows]
        names = [title + ", no units spent" * ((scene, title) in free) for title in titles]
        found[scene] = [Markup(panel) for panel in curve_figures(rows, names)]
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


def _panels(data: Mapping[str, Any], scene: str) -> list[Markup]:
    """The charts of one scene for the page."""
    limits = data["settings"]["thresholds"]
    names = list(dict.fromkeys(title_of(row, data) for row in data["summary"]))
    finished = [row for row in data["trials"] if row["scene"] == scene and row["ratio"] is not None]
    if not finished:
        return []
    trials = [[row for row in finished if title_of(row, data) == name] for name in names]
    ratio = {"r": [[row["ratio"] for row in rows] for rows in trials]}
    errors = {
        axis: [[max(row["rotation_error_deg"][axis], _LEAST_ERROR) for row in rows] for rows in trials]
        for axis in ("pitch", "yaw", "roll")
    }
    panels = [
        strips(names, ratio, "r = N_o / N_GT", (limits["ratio"], limits["flagged_ratio"]), log=False, tall=3),
        strips(names, errors, "rotation error [°]", (limits["pitch_roll_deg"], limits["yaw_deg"]), log=True),
    ]
    return [Markup(panel) for panel in panels]
