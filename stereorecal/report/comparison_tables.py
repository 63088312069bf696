"""Terminal tables of a comparison, from the plain data of its JSON."""

from collections import Counter
from collections.abc import Mapping
from itertools import zip_longest
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from stereorecal.report._tables import tables_of
from stereorecal.report.number_text import count, number, percent

TRIALS = "trials"
_MOST_TRIALS = 24  # of which every one has a row
_COUNTS = {"N_i": "initial", "N_o": "final", "N_GT": "reference"}
_ERRORS = {  # heads of columns: what they show, with so many decimals
    **{f"{axis}°": ("rotation_error_deg", axis, 3) for axis in ("pitch", "yaw", "roll")},
    **{f"{axis} %": ("translation_error_percent", axis, 2) for axis in ("y", "z")},
}
_SCORES = (*_COUNTS, "r", "status", "evals", "units", "s")
_PIXELS = {"px before": "start", "px after": "final"}
_PLACES = ("first", "second", "third")
WORDS = ("scene", "schedule", "strategy", *_PLACES)

Row = Mapping[str, Any]


def several_schedules(data: Mapping[str, Any]) -> bool:
    """Whether schedules stand side by side."""
    return len({entrant["schedule"] for entrant in data["settings"]["entrants"]}) > 1


def strategies_of(row: Row) -> str:
    """The strategies that a trial or a summary ran: "compass + optimistix-levenberg-marquardt"."""
    return " + ".join(row["strategies"])


def title_of(row: Row, data: Mapping[str, Any]) -> str:
    """A short name, different for each entrant: its schedule where schedules stand side by side, each with strategies
    of its own, else the requested strategy."""
    return row["schedule"] if several_schedules(data) else row["strategy"]


def comparison_tables(data: Mapping[str, Any], width: int) -> Group:
    """All trials if 24 or fewer, then their medians; scores and errors side by side if `width` allows, else one below
    the other, with strategies that their schedule names only at the scores."""
    shown = {**rows_by_title(data), "best median score by units spent": _leaders(data)}
    if not 1 < len(data["trials"]) <= _MOST_TRIALS:
        del shown[TRIALS]
    scores = (*_SCORES, "strategy") if several_schedules(data) else _SCORES
    tables: list[Table] = []
    for title, rows in shown.items():
        parts = (scores, ("success", *_ERRORS)) if rows and "r" in rows[0] else ()
        tables += tables_of(rows, width, WORDS, title=_title(title, data), parts=parts) if rows else []
    legend = (f"{name}: {meaning}.\n" for name, meaning in terms(data).items())
    reasons = (f"{name} {status}: {message}\n" for name, status, message in troubles(data))
    return Group(*tables, Text("".join([*legend, *reasons])))


def rows_by_title(data: Mapping[str, Any]) -> dict[str, list[dict[str, str]]]:
    """The rows of the trials, of their medians, and of the errors by the true rig, if it is known."""
    draws, summary = data["settings"]["draws"], data["summary"]
    unequal = any(row["draws"] != draws for row in summary)
    over = "the finished draws" if unequal else "1 draw" if draws == 1 else f"{draws} draws"
    return {
        TRIALS: [_trial(row, data) for row in data["trials"]],
        f"medians over {over}": [_medians(row, data, unequal=unequal) for row in summary],
        "by the true rig": [_truth(row, data) for row in summary if row.get("harmful") is not None],
    }


def _trial(row: Row, data: Mapping[str, Any]) -> dict[str, str]:
    about = _about(row, data, short=True)
    return {**about, "draw": str(row["draw"]), **_results(row, data, ""), "status": row["status"]}


def _medians(row: Row, data: Mapping[str, Any], *, unequal: bool) -> dict[str, str]:
    draws = {"draws": str(row["draws"])} if unequal else {}
    # Evaluations of different scores do not compare.
    evaluations = {} if several_schedules(data) else {"evals": count(row["evaluations_median"])}
    spent = {"units": number(row["cost_median"], 1), "s": number(row["seconds_median"], 1)}
    results = {"success": percent(row["success_rate"]), **_results(row, data, "_median")}
    return {**_about(row, data), **draws, **results, **evaluations, **spent}


def _truth(row: Row, data: Mapping[str, Any]) -> dict[str, str]:
    """What the true rig says of epipolar errors and depth."""
    pixels, depth = row["row_error_px_median"], row["depth_error_percent_median"]
    errors = {head: number(pixels[when], 2) for head, when in _PIXELS.items()}
    far = {f"{at} B %": number(depth[at], 1) for at in ("10", "30")}
    return {**_about(row, data, short=True), **errors, **far, "harmful": str(row["harmful"])}


def _leaders(data: Mapping[str, Any]) -> list[dict[str, str]]:
    """The three strategies with the best median score at each budget in units, within that of the comparison; none
    where there is one strategy, or no scores were recorded."""
    most, found = data["settings"]["budget"]["evaluations"] or float("inf"), []
    for scene, name in _short_names(data).items() if len(data["settings"]["strategies"]) > 1 else ():
        rows = [row for row in data["summary"] if row["scene"] == scene]
        marks = rows[0]["score_at_median"] if rows else ()
        for units in (units for units in marks if float(units) <= most):
            reached = [(row["score_at_median"][units], row["strategy"]) for row in rows]
            ranked = sorted((one for one in reached if one[0] is not None), key=lambda one: (-one[0], one[1]))[:3]
            if ranked:
                leaders = (f"{strategy} {count(value)}" for value, strategy in ranked)
                found.append({"scene": name, "units": units, **dict(zip_longest(_PLACES, leaders, fillvalue=""))})
    return found


_REFERENCES = {
    "truth": "the true rig",
    "stored": "the stored calibration",
    "consensus": "the end point of the default schedule from the stored calibration: repeatability, not accuracy",
}


def terms(data: Mapping[str, Any]) -> dict[str, str]:
    """What the tables mean, by their heads."""
    limits = data["settings"]["thresholds"]
    references = dict.fromkeys(str(scene["reference"]) for scene in data["scenes"])
    schedules = {
        "schedule default": "coarse to fine, first the count, then the epipolar (row) error; what recalibrate does",
        "schedule count": f"the paper's way, the count alone, at scale {data['settings']['scale']:g}",
    }
    truth = {
        "px": "epipolar error over the view, by the true rig",
        "10 B %, 30 B %": "|depth error| at so many baselines, by the true rig",
        "harmful": "trials after which the epipolar error is larger by more than "
        f"{limits['harmful_rows_px']} px, or the depth error at 30 baselines by more than "
        f"{limits['harmful_depth_percent']:g} % of the distance",
    }
    return {
        **(schedules if several_schedules(data) else {}),
        "N_i, N_o, N_GT": "pixels matched with the initial, the recalibrated and the reference calibration",
        "r": f"N_o / N_GT; ! above {limits['flagged_ratio']}: a wrong calibration may score higher than the right one",
        "reference, and what errors are measured against": "; ".join(_REFERENCES.get(r, r) for r in references),
        "success": f"r >= {limits['ratio']}, pitch and roll within {limits['pitch_roll_deg']}°, yaw within "
        f"{limits['yaw_deg']}°; failed trials are none, skipped ones are left out",
        "units": "what a budget pays for, in matcher runs on full-size frames: the search, not the looks before it",
        **(truth if any(row.get("harmful") is not None for row in data["summary"]) else {}),
    }


def troubles(data: Mapping[str, Any]) -> Counter[tuple[str, str, str]]:
    """The number of trials that were skipped or failed, by entrant, status and message."""
    unfinished = (row for row in data["trials"] if row["status"] in ("SKIPPED", "FAILED"))
    return Counter((title_of(row, data), row["status"], row["message"]) for row in unfinished)


def _short_names(data: Mapping[str, Any]) -> dict[str, str]:
    """Scene names without the name of their data set, if they stay distinct."""
    names = [scene["name"] for scene in data["scenes"]]
    short = [name.rpartition("/")[2] for name in names]
    return dict(zip(names, short if len(set(short)) == len(names) else names, strict=True))


def _title(what: str, data: Mapping[str, Any]) -> str:
    settings, names = data["settings"], list(_short_names(data).values())
    about = [*(names if len(names) == 1 else ()), f"matcher {settings['matcher']['name']}"]
    if not several_schedules(data):
        schedule = settings["schedule"]
        about.append(f"schedule {schedule}" + (f" at scale {settings['scale']:g}" if schedule == "count" else ""))
    return f"{what} ({', '.join(about)})"


def _about(row: Row, data: Mapping[str, Any], *, short: bool = False) -> dict[str, str]:
    """The scene and the schedule, where there are several, and the strategies that ran (`short`: not where the
    schedule says which)."""
    names, several = _short_names(data), several_schedules(data)
    scene = {"scene": names[row["scene"]]} if len(names) > 1 else {}
    schedule = {"schedule": row["schedule"]} if several else {}
    return scene | schedule | ({} if short and several else {"strategy": strategies_of(row)})


def _results(row: Row, data: Mapping[str, Any], suffix: str) -> dict[str, str]:
    """Scores and errors of a trial, or of their medians."""
    ratio, flagged = row[f"ratio{suffix}"], data["settings"]["thresholds"]["flagged_ratio"]
    return {
        **{head: count(row[f"score_{when}{suffix}"]) for head, when in _COUNTS.items()},
        "r": number(ratio, 3) + "!" * (ratio is not None and ratio > flagged),
        **{
            head: number((row[f"{of}{suffix}"] or {}).get(axis), digits) for head, (of, axis, digits) in _ERRORS.items()
        },
    }
