"""Terminal tables of a comparison, from the plain data of its JSON."""

import textwrap
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from rich import box
from rich.cells import cell_len
from rich.console import Group
from rich.table import Column, Table
from rich.text import Text

from stereorecal.report._table_width import first_that_fits
from stereorecal.report.number_text import count, number, percent

_MOST_TRIALS = 24  # of which every one has a row
WIDE = 120  # columns of a table that is not printed to a terminal
_FOLDS = (40, 21, 12)  # characters a line of "compass + optimistix-levenberg-marquardt": in one line, in two, in four
_LEAST = {"strategy": 12, "schedule": 8}  # characters of a column, however narrow the terminal
_LEAST_MISSED = (
    "N_i",
    "N_GT",
    "evals",
    "z %",
    "y %",
    "draws",
    "status",
    "s",
    "success",
    "10 B %",
    "px before",
    "px after",
)  # columns, the first is missed least
_SIDE_BY_SIDE, _APART = (("scores", "errors"),), (("scores",), ("errors",))
_ROTATIONS, _TRANSLATIONS = ("pitch", "yaw", "roll"), ("y", "z")
_COUNTS = ("initial", "final", "reference")

Row = Mapping[str, Any]
_Make = Callable[[Mapping[str, Any], Sequence[str], int], Table]


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
    """All trials if 24 or fewer, then their medians; scores and errors side by side if `width` allows."""
    kinds: list[tuple[str, _Make]] = [("the medians", _summary_table)]
    if 1 < len(data["trials"]) <= _MOST_TRIALS:
        kinds.insert(0, ("the trials", _trials_table))
    tables, missed = [], []
    for name, make in kinds:
        narrowed = [_narrowed(table, width) for table in _fitted(make, data, width)]
        tables += [table for table, _ in narrowed]
        dropped = dict.fromkeys(head for _, heads in narrowed for head in heads)
        missed += [f"{', '.join(dropped)} of {name}"] * bool(dropped)
    if any(row.get("harmful") is not None for row in data["summary"]):
        (table,) = first_that_fits([partial(_truth_table, data, fold) for fold in _FOLDS], width)
        table, dropped = _narrowed(table, width)
        tables.append(table)
        missed += [f"{', '.join(dropped)} of the errors by the true rig"] * bool(dropped)
    omissions = f"left out in {width} columns: {'; '.join(missed)}.\n" if missed else ""
    leaders = _leaders_table(data)
    if len(data["settings"]["strategies"]) > 1 and leaders.row_count:
        tables.append(leaders)
    return Group(*tables, Text(omissions + _legend(data) + _troubles(data)))


def _fitted(make: _Make, data: Mapping[str, Any], width: int) -> Sequence[Table]:
    """The widest layout of a table, in one part or in two, that fits; else the narrowest."""

    def layout(parts: Sequence[Sequence[str]], fold: int) -> list[Table]:
        return [make(data, part, fold) for part in parts]

    layouts = [(_SIDE_BY_SIDE, fold) for fold in _FOLDS[:2]] + [(_APART, fold) for fold in _FOLDS]
    return first_that_fits([partial(layout, *one) for one in layouts], width)


def _narrowed(table: Table, width: int) -> tuple[Table, list[str]]:
    """A table without as many columns as it takes to fit, those first that are missed least; and their heads."""
    columns, dropped = list(table.columns), []
    for head in _LEAST_MISSED:
        if _least(columns) <= width:
            break
        dropped += [head for column in columns if column.header == head]
        columns = [column for column in columns if column.header != head]
    if not dropped:
        return table, []
    narrow = Table(box=table.box, title=table.title, title_justify="left", padding=table.padding, pad_edge=False)
    for c in columns:
        narrow.add_column(c.header, justify=c.justify, overflow=c.overflow, no_wrap=c.no_wrap, min_width=c.min_width)
    for cells in zip(*(column.cells for column in columns), strict=True):
        narrow.add_row(*cells)
    return narrow, dropped


def _least(columns: Sequence[Column]) -> int:
    """The width of a table when all that may be folded is."""
    widths = [
        max(cell_len(str(cell)) for cell in (column.header, *column.cells))
        if column.no_wrap
        else column.min_width or _LEAST["schedule"]
        for column in columns
    ]
    return sum(widths) + 2 * len(widths) + 1  # gaps and edges


def _trials_table(data: Mapping[str, Any], parts: Sequence[str], fold: int) -> Table:
    flagged_ratio = data["settings"]["thresholds"]["flagged_ratio"]
    table = _table("trials", data)
    heads, about = _row_headings(data, fold, short=True)
    _add_columns(table, heads, parts, ["draw"], ["status"])
    for trial in data["trials"]:
        status = [trial["status"]] if "scores" in parts else []
        cells = (*about(trial), str(trial["draw"]), *_results(trial, parts, "", flagged_ratio), *status)
        table.add_row(*map(Text, cells))
    return table


def _summary_table(data: Mapping[str, Any], parts: Sequence[str], fold: int) -> Table:
    settings = data["settings"]
    flagged_ratio, draws = settings["thresholds"]["flagged_ratio"], settings["draws"]
    unequal = any(row["draws"] != draws for row in data["summary"])
    draws = "the finished draws" if unequal else "1 draw" if draws == 1 else f"{draws} draws"
    table = _table(f"medians over {draws}", data)
    evaluations = not several_schedules(data)  # those of different scores do not compare
    first = (["draws"] if unequal else []) + (["success"] if "errors" in parts else [])
    heads, about = _row_headings(data, fold)
    _add_columns(table, heads, parts, first, ["evals", "s"] if evaluations else ["s"])
    for row in data["summary"]:
        cells = [*about(row), *([str(row["draws"])] if unequal else [])]
        cells += [percent(row["success_rate"])] if "errors" in parts else []
        cells += _results(row, parts, "_median", flagged_ratio)
        if "scores" in parts:
            cells += [count(row["evaluations_median"])] if evaluations else []
            cells.append(number(row["seconds_median"], 1))
        table.add_row(*map(Text, cells))
    return table


def _truth_table(data: Mapping[str, Any], fold: int) -> list[Table]:
    """What the true rig says of rows and depth, where it is known."""
    table = _table("by the true rig", data)
    heads, about = _row_headings(data, fold)
    for heading in heads:
        table.add_column(heading, overflow="fold", min_width=_LEAST.get(heading))
    for heading in ("px before", "px after", "10 B %", "30 B %", "harmful"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in data["summary"]:
        if row.get("harmful") is None:
            continue
        rows, depth = row["row_error_px_median"], row["depth_error_percent_median"]
        cells = [number(rows["start"], 2), number(rows["final"], 2), *(number(depth[at], 1) for at in ("10", "30"))]
        table.add_row(*map(Text, (*about(row), *cells, str(row["harmful"]))))
    return [table]


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


def schedules_legend(data: Mapping[str, Any]) -> dict[str, str]:
    """What the schedules are, by name, where several stand side by side."""
    if not several_schedules(data):
        return {}
    return {
        "default": "coarse to fine, first the count, then the epipolar (row) error; what recalibrate does",
        "count": f"the paper's way, the count alone, at scale {data['settings']['scale']:g}",
    }


def _legend(data: Mapping[str, Any]) -> str:
    limits = data["settings"]["thresholds"]
    references = dict.fromkeys(str(scene["reference"]) for scene in data["scenes"])
    schedules = (f"schedule {name}: {meaning}.\n" for name, meaning in schedules_legend(data).items())
    return (
        "".join(schedules)
        + "N_i, N_o, N_GT: pixels matched with the initial, the recalibrated and the reference calibration.\n"
        f"r = N_o / N_GT; ! above {limits['flagged_ratio']}: a wrong calibration may score higher than the right one.\n"
        f"reference, and what errors are measured against: {'; '.join(REFERENCES.get(r, r) for r in references)}.\n"
        f"success: r >= {limits['ratio']}, pitch and roll within {limits['pitch_roll_deg']}°, "
        f"yaw within {limits['yaw_deg']}°.\n" + _truth_legend(data)
    )


def _truth_legend(data: Mapping[str, Any]) -> str:
    if all(row.get("harmful") is None for row in data["summary"]):
        return ""
    limits = data["settings"]["thresholds"]
    return (
        "px: row error over the view; 10 B %, 30 B %: |depth error| at so many baselines; all by the true rig.\n"
        f"harmful: trials after which the row error is larger by more than {limits['harmful_rows_px']} px, or the "
        f"depth error at 30 baselines by more than {limits['harmful_depth_percent']:g} % of the distance.\n"
    )


def _troubles(data: Mapping[str, Any]) -> str:
    """The reasons why trials were skipped or failed, each once."""
    unfinished = [trial for trial in data["trials"] if trial["status"] in ("SKIPPED", "FAILED")]
    reasons = dict.fromkeys(f"{title_of(t, data)} {t['status']}: {t['message']}\n" for t in unfinished)
    return "".join(reasons)


def _short_names(data: Mapping[str, Any]) -> dict[str, str]:
    """Scene names without the name of their data set, if they stay distinct."""
    names = [scene["name"] for scene in data["scenes"]]
    short = [name.rpartition("/")[2] for name in names]
    return dict(zip(names, short if len(set(short)) == len(names) else names, strict=True))


def _table(title: str, data: Mapping[str, Any]) -> Table:
    settings, names = data["settings"], list(_short_names(data).values())
    about = [f"matcher {settings['matcher']['name']}"]
    if len(names) == 1:
        about.insert(0, names[0])
    if not several_schedules(data):
        schedule = settings["schedule"]
        about.append(f"schedule {schedule}" + (f" at scale {settings['scale']:g}" if schedule == "count" else ""))
    text = Text(f"{title} ({', '.join(about)})")
    return Table(box=box.SIMPLE_HEAD, title=text, title_justify="left", padding=(0, 1, 0, 0), pad_edge=False)


def _row_headings(
    data: Mapping[str, Any], fold: int, *, short: bool = False
) -> tuple[list[str], Callable[[Row], list[str]]]:
    """The heads of the columns that say what a row is about, and its cells: the scene and the schedule, where there are
    several, and the strategies that ran (`short`: not where the schedule says which)."""
    names = _short_names(data)
    columns: dict[str, Callable[[Row], str]] = {}
    if len(names) > 1:
        columns["scene"] = lambda row: names[row["scene"]]
    if several_schedules(data):
        columns["schedule"] = lambda row: row["schedule"]
    if not (short and several_schedules(data)):
        columns["strategy"] = lambda row: "\n".join(textwrap.wrap(strategies_of(row), fold))
    return list(columns), lambda row: [cell(row) for cell in columns.values()]


def _add_columns(
    table: Table, about: Sequence[str], parts: Sequence[str], first: Sequence[str], last: Sequence[str]
) -> None:
    for heading in about:
        table.add_column(heading, overflow="fold", min_width=_LEAST.get(heading))
    headings = list(first)
    if "scores" in parts:
        headings += ["N_i", "N_o", "N_GT", "r"]
    if "errors" in parts:
        headings += [f"{axis}°" for axis in _ROTATIONS] + [f"{axis} %" for axis in _TRANSLATIONS]
    if "scores" in parts:
        headings += last
    for heading in headings:
        table.add_column(heading, justify="left" if heading == "status" else "right", no_wrap=True)


def _results(row: Row, parts: Sequence[str], suffix: str, flagged_ratio: float) -> list[str]:
    """The cells of scores and errors of a trial, or of their medians."""
    cells = []
    if "scores" in parts:
        cells += [count(row[f"score_{when}{suffix}"]) for when in _COUNTS]
        cells.append(_ratio(row[f"ratio{suffix}"], flagged_ratio))
    if "errors" in parts:
        cells += _errors(row[f"rotation_error_deg{suffix}"], row[f"translation_error_percent{suffix}"])
    return cells


def _errors(rotation: Mapping[str, float] | None, translation: Mapping[str, float] | None) -> list[str]:
    if rotation is None or translation is None:
        return ["-"] * 5
    return [number(rotation[a], 3) for a in _ROTATIONS] + [number(translation[a], 2) for a in _TRANSLATIONS]


def _ratio(value: float | None, flagged_ratio: float) -> str:
    if value is None:
        return "-"
    return f"{value:.3f}{'!' if value > flagged_ratio else ''}"
