"""Terminal tables of a comparison, from the plain data of its JSON."""

from collections.abc import Mapping
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from stereorecal.report._cells import count, number, percent

WIDE = 120  # characters that scores and errors need side by side
_SHORT = 12  # of them for the name of a strategy
_ROTATIONS, _TRANSLATIONS = ("pitch", "yaw", "roll"), ("y", "z")
_COUNTS = ("initial", "final", "reference")


def comparison_tables(data: Mapping[str, Any], width: int, most_trials: int = 24) -> Group:
    """The summary, and all trials if `most_trials` or fewer; scores and errors side by side if `width` allows."""
    longest = max(map(len, data["settings"]["strategies"]), default=0)
    side_by_side = width >= WIDE + max(0, longest - _SHORT)
    parts = [("scores", "errors")] if side_by_side else [("scores",), ("errors",)]
    tables = []
    if 1 < len(data["trials"]) <= most_trials:
        tables += [_trials_table(data, columns) for columns in parts]
    tables += [_summary_table(data, columns) for columns in parts]
    leaders = _leaders_table(data)
    if len(data["settings"]["strategies"]) > 1 and leaders.row_count:
        tables.append(leaders)
    return Group(*tables, Text(_legend(data) + _troubles(data)))


def _trials_table(data: Mapping[str, Any], parts: tuple[str, ...]) -> Table:
    flagged_ratio = data["settings"]["thresholds"]["flagged_ratio"]
    names = _short_names(data)
    table = _table("trials", data)
    _add_columns(table, parts, ("draw",), ("status",))
    for trial in data["trials"]:
        cells = [names[trial["scene"]], trial["strategy"], str(trial["draw"])]
        if "scores" in parts:
            cells += [count(trial[f"score_{when}"]) for when in _COUNTS]
            cells += [_ratio(trial["ratio"], flagged_ratio)]
        if "errors" in parts:
            cells += _errors(trial["rotation_error_deg"], trial["translation_error_percent"])
        if "scores" in parts:
            cells.append(trial["status"])
        table.add_row(*map(Text, cells))
    return table


def _summary_table(data: Mapping[str, Any], parts: tuple[str, ...]) -> Table:
    flagged_ratio = data["settings"]["thresholds"]["flagged_ratio"]
    names = _short_names(data)
    table = _table("medians", data)
    _add_columns(table, parts, ("draws", "success"), ("evals", "s"))
    for row in data["summary"]:
        cells = [names[row["scene"]], row["strategy"], str(row["draws"]), percent(row["success_rate"])]
        if "scores" in parts:
            cells += [count(row[f"score_{when}_median"]) for when in _COUNTS]
            cells += [_ratio(row["ratio_median"], flagged_ratio)]
        if "errors" in parts:
            cells += _errors(row["rotation_error_deg_median"], row["translation_error_percent_median"])
        if "scores" in parts:
            cells += [count(row["evaluations_median"]), number(row["seconds_median"], 1)]
        table.add_row(*map(Text, cells))
    return table


def _leaders_table(data: Mapping[str, Any]) -> Table:
    """The three strategies with the best median score at each budget, in units, within that of the comparison.

    Empty where no scores were recorded.
    """
    names = _short_names(data)
    table = _table("best median score by units spent", data)
    for heading in ("scene", "units", "first", "second", "third"):
        table.add_column(heading, justify="right" if heading == "units" else "left", overflow="fold")
    for scene, name in names.items():
        rows = [row for row in data["summary"] if row["scene"] == scene]
        for units in rows[0]["score_at_median"] if rows else ():
            if float(units) > (data["settings"]["budget"]["evaluations"] or float("inf")):
                continue
            reached = [(row["score_at_median"][units], row["strategy"]) for row in rows]
            ranked = sorted((r for r in reached if r[0] is not None), key=lambda r: (-r[0], r[1]))[:3]
            if not ranked:
                continue
            cells = [f"{strategy} {count(value)}" for value, strategy in ranked]
            table.add_row(*map(Text, (name, units, *cells, *[""] * (3 - len(cells)))))
    return table


REFERENCES = {
    "truth": "the true rig",
    "stored": "the stored calibration",
    "consensus": "the end point of the default schedule from the stored calibration: repeatability, not accuracy",
}


def _legend(data: Mapping[str, Any]) -> str:
    limits = data["settings"]["thresholds"]
    references = dict.fromkeys(str(scene["reference"]) for scene in data["scenes"])
    return (
        "N_i, N_o, N_GT: pixels matched with the initial, the recalibrated and the reference calibration.\n"
        f"r = N_o / N_GT; ! above {limits['flagged_ratio']}: a wrong calibration may score higher than the right one.\n"
        f"errors: relative to {'; '.join(REFERENCES.get(r, r) for r in references)}.\n"
        f"success: r >= {limits['ratio']}, pitch and roll within {limits['pitch_roll_deg']}°, "
        f"yaw within {limits['yaw_deg']}°.\n"
    )


def _troubles(data: Mapping[str, Any]) -> str:
    """The reasons why trials were skipped or failed, each once."""
    unfinished = [trial for trial in data["trials"] if trial["status"] in ("SKIPPED", "FAILED")]
    reasons = dict.fromkeys(f"{t['strategy']} {t['status']}: {t['message']}\n" for t in unfinished)
    return "".join(reasons)


def _short_names(data: Mapping[str, Any]) -> dict[str, str]:
    """Scene names without the name of their data set, if they stay distinct."""
    names = [scene["name"] for scene in data["scenes"]]
    short = [name.rpartition("/")[2] for name in names]
    return dict(zip(names, short if len(set(short)) == len(names) else names, strict=True))


def _table(title: str, data: Mapping[str, Any]) -> Table:
    matcher = data["settings"]["matcher"]["name"]
    schedule, scale = data["settings"]["schedule"], data["settings"]["scale"]
    at_scale = f" at scale {scale:g}" if schedule == "count" else ""
    title = f"{title} ({matcher}, schedule {schedule}{at_scale})"
    return Table(box=box.SIMPLE_HEAD, title=title, title_justify="left", padding=(0, 1, 0, 0), pad_edge=False)


def _add_columns(table: Table, parts: tuple[str, ...], first: tuple[str, ...], last: tuple[str, ...]) -> None:
    table.add_column("scene", overflow="fold")
    table.add_column("strategy", overflow="fold")
    headings = list(first)
    if "scores" in parts:
        headings += ["N_i", "N_o", "N_GT", "r"]
    if "errors" in parts:
        headings += [f"{axis}°" for axis in _ROTATIONS] + [f"{axis} %" for axis in _TRANSLATIONS]
    if "scores" in parts:
        headings += last
    for heading in headings:
        table.add_column(heading, justify="left" if heading == "status" else "right", no_wrap=True)


def _errors(rotation: Mapping[str, float] | None, translation: Mapping[str, float] | None) -> list[str]:
    if rotation is None or translation is None:
        return ["-"] * 5
    return [number(rotation[a], 3) for a in _ROTATIONS] + [number(translation[a], 2) for a in _TRANSLATIONS]


def _ratio(value: float | None, flagged_ratio: float) -> str:
    if value is None:
        return "-"
    return f"{value:.3f}{'!' if value > flagged_ratio else ''}"
