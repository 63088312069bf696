"""Tables of the paper's experiments for the terminal, from the plain data of `reproduce`."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from stereorecal.report.number_text import count, number, percent

Row = Mapping[str, Any]
_ROTATIONS, _TRANSLATIONS = ("pitch", "yaw", "roll"), ("y", "z")
_ERRORS = [f"{axis}°" for axis in _ROTATIONS] + [f"{axis} %" for axis in _TRANSLATIONS]
_LEGEND = """\
N_i, N_o, N_GT: pixels matched with the initial, the recalibrated and the manual calibration, in one view.
r = N_o / N_GT. Errors: relative to the true rig where it is known, else to the manual calibration.
*: a pair with little to match, such as open sea.
schedule: count (the paper's way: the count alone, at one scale, with the disparity range of the manual calibration) and
default (coarse to fine, with a range of its own). Medians are over pairs without a star.
s: seconds; the first repairs compile."""


def experiment_tables(data: Mapping[str, Any]) -> Group:
    """The tables of all experiments that ran, with the paper's own summary where it has one."""
    parts = [make(data) for name, make in _TABLES.items() if data["rows"].get(name)]
    return Group(*[table for tables in parts for table in tables], Text(_LEGEND))


def _validity(data: Mapping[str, Any]) -> list[Table]:
    table = _table("validity: on how many pairs is the count highest under their own calibration? (paper 4.1)")
    _columns(table, ("sequence", "calibration"), ("pairs", "own is highest", "next best / own"))
    for row in data["summary"]["validity"]:
        _add(
            table,
            row["sequence"],
            row["calibration"],
            str(row["pairs"]),
            str(row["own_highest"]),
            number(row["next_best_share"], 2),
        )
    return [table]


def _sweeps(data: Mapping[str, Any]) -> list[Table]:
    table = _table(
        "sweeps: the count along one axis through the reference; medians, degrees or % of the baseline (paper 4.1)"
    )
    _columns(table, ("axis", "matcher"), ("peak at", "width at half height", "width within 1 % of the peak"))
    for row in data["summary"]["sweeps"]:
        _add(
            table,
            row["axis"],
            row["matcher"],
            f"{row['peak']:+.3f}",
            ("> " if row["half_cut"] else "") + number(row["half_width"], 2),
            number(row["flat_width"], 3),
        )
    return [table]


def _repairs(name: str, title: str) -> Callable[[Mapping[str, Any]], list[Table]]:
    def tables(data: Mapping[str, Any]) -> list[Table]:
        single = _table(title)
        words, numbers = ("sequence", "image", "from", "schedule"), ("N_i", "N_o", "N_GT", "r", *_ERRORS)
        _columns(single, words, numbers, ("verdict",))
        for row in data["rows"][name]:
            image = row["image"].rpartition(".")[0] + ("*" if row["starred"] else "")
            _add(
                single,
                row["sequence"],
                image,
                row["calibration"],
                row["schedule"],
                *(count(row[f"score_{when}"]) for when in ("initial", "final", "reference")),
                number(row["score_final"] / row["score_reference"] if row["score_reference"] else None, 3),
                *_errors(row),
                row["reason"].replace("_", " "),
            )
        return [single, _summary(f"{name.replace('_', ' ')}: summary", data["summary"][name])]

    return tables


def _summary(title: str, rows: Sequence[Row]) -> Table:
    table = _table(title)
    shares = ("r >= 1", "r >= 0.99", "r >= 0.98")
    _columns(table, ("schedule",), ("pairs", "median r", *shares, *_ERRORS, "s", "*", "* refused", "* worse"))
    for row in rows:
        ours = "seconds_median" in row
        _add(
            table,
            row["schedule"],
            str(row["rows"]),
            number(row["r_median"], 3),
            *(percent(row[f"share_r_{least}"]) for least in ("1", "0.99", "0.98")),
            *(_errors(row, "_median") if ours else ["-"] * 5),
            number(row["seconds_median"] if ours else None, 1),
            *(str(row[key]) if ours else "-" for key in ("starred", "starred_refused", "starred_worse")),
        )
    return table


def _generalise(data: Mapping[str, Any]) -> list[Table]:
    first = data["rows"]["generalise"][0]
    table = _table(f"generalise: {first['sequence']}, optimised on {first['image']}, judged on the others (paper 4.3)")
    numbers = ("initial error", "r", "others before", "others after", "improved", "of")
    _columns(table, ("from", "schedule"), numbers)
    for row in data["summary"]["generalise"]:
        _add(
            table,
            row["calibration"],
            row["schedule"],
            f"{row['start_error_deg']:.2f}°",
            *(number(row[key], 3) for key in ("r", "r_others_before", "r_others_after")),
            str(row["improved"]),
            str(row["others"]),
        )
    return [table]


def _sequential(data: Mapping[str, Any]) -> list[Table]:
    sequence = data["rows"]["sequential"][0]["sequence"]
    table = _table(f"sequential: {sequence}, one pair after the other (paper 4.5)")
    _columns(table, ("order", "schedule"), ("pairs", "accepted", "r first", "median", "last", *_ERRORS))
    for row in data["summary"]["sequential"]:
        _add(
            table,
            row["order"],
            row["schedule"],
            str(row["steps"]),
            str(row["accepted"]),
            *(number(row[key], 3) for key in ("r_first", "r_median", "r_last")),
            *_errors(row),
        )
    return [table]


_TABLES: dict[str, Callable[[Mapping[str, Any]], list[Table]]] = {
    "validity": _validity,
    "sweeps": _sweeps,
    "repair": _repairs("repair", "repair: from a calibration of another date (paper 4.2, table 1)"),
    "generalise": _generalise,
    "ex_nihilo": _repairs("ex_nihilo", "ex nihilo: from [0, 0, 0, -B, 0, 0] (paper 4.4, table 2)"),
    "sequential": _sequential,
}


def _errors(row: Row, suffix: str = "") -> list[str]:
    rotation, translation = row[f"rotation_error_deg{suffix}"], row[f"translation_error_percent{suffix}"]
    if rotation is None or translation is None:
        return ["-"] * 5
    return [number(rotation[a], 3) for a in _ROTATIONS] + [number(translation[a], 2) for a in _TRANSLATIONS]


def _table(title: str) -> Table:
    return Table(box=box.SIMPLE_HEAD, title=Text(title), title_justify="left", padding=(0, 1, 0, 0), pad_edge=False)


def _add(table: Table, *cells: str) -> None:
    """A row of plain words: names are not markup."""
    table.add_row(*map(Text, cells))


def _columns(table: Table, words: Iterable[str], numbers: Iterable[str], last: Iterable[str] = ()) -> None:
    for heading in words:
        table.add_column(heading, overflow="fold")
    for heading in numbers:
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in last:
        table.add_column(heading, overflow="fold")
