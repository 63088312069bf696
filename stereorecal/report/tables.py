"""Tables for the terminal, from the plain data of a comparison's JSON."""

from collections.abc import Mapping
from typing import Any

from rich import box
from rich.table import Table

_AXES = ("pitch", "yaw", "roll")


def trials_table(data: Mapping[str, Any]) -> Table:
    """One row a trial: the paper's N_i, N_o, N_GT and r, and the errors of each axis."""
    table = _table("each trial: pixels matched before (N_i), after (N_o), at the reference (N_GT); r = N_o / N_GT")
    for heading in ("scene", "strategy", "draw", "N_i", "N_o", "N_GT", "r"):
        table.add_column(heading, justify="left" if heading in ("scene", "strategy") else "right", no_wrap=True)
    _add_error_columns(table)
    table.add_column("status", overflow="fold")
    flagged_ratio = data["settings"]["thresholds"]["flagged_ratio"]
    for trial in data["trials"]:
        unfinished = trial["score_final"] is None
        table.add_row(
            trial["scene"],
            trial["strategy"],
            str(trial["draw"]),
            *[_count(trial[f"score_{when}"]) for when in ("initial", "final", "reference")],
            _ratio(trial["ratio"], flagged_ratio),
            *_errors(trial["rotation_error_deg"], trial["translation_error_percent"]),
            f"{trial['status']}: {trial['message']}" if unfinished else trial["status"],
        )
    return table


def summary_table(data: Mapping[str, Any]) -> Table:
    """One row for each scene, matcher and strategy: medians and success rates."""
    limits = data["settings"]["thresholds"]
    table = _table(
        f"medians; success: r >= {limits['ratio']}, pitch and roll within {limits['pitch_roll_deg']}°, "
        f"yaw within {limits['yaw_deg']}° of the reference"
    )
    for heading in ("scene", "matcher", "strategy"):
        table.add_column(heading, no_wrap=True)
    for heading in ("draws", "success", "N_i", "N_o", "N_GT", "r"):
        table.add_column(heading, justify="right", no_wrap=True)
    _add_error_columns(table)
    for heading in ("evals", "units", "s"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in data["summary"]:
        table.add_row(
            row["scene"],
            row["matcher"],
            row["strategy"],
            _draws(row),
            "-" if row["success_rate"] is None else f"{100 * row['success_rate']:.0f} %",
            *[_count(row[f"score_{when}_median"]) for when in ("initial", "final", "reference")],
            _ratio(row["ratio_median"], limits["flagged_ratio"]),
            *_errors(row["rotation_error_deg_median"], row["translation_error_percent_median"]),
            *[_count(row[f"{what}_median"]) for what in ("evaluations", "cost")],
            "-" if row["seconds_median"] is None else f"{row['seconds_median']:.1f}",
        )
    return table


def _table(caption: str) -> Table:
    return Table(box=box.SIMPLE_HEAD, caption=caption, caption_justify="left", pad_edge=False)


def _add_error_columns(table: Table) -> None:
    for heading in (*(f"{axis}°" for axis in _AXES), "y %", "z %"):
        table.add_column(heading, justify="right", no_wrap=True)


def _errors(rotation: Mapping[str, float] | None, translation: Mapping[str, float] | None) -> list[str]:
    if rotation is None or translation is None:
        return ["-"] * 5
    return [f"{rotation[axis]:.3f}" for axis in _AXES] + [f"{translation[axis]:.2f}" for axis in ("y", "z")]


def _count(value: float | None) -> str:
    return "-" if value is None else f"{value:,.0f}".replace(",", " ")


def _ratio(value: float | None, flagged_ratio: float) -> str:
    if value is None:
        return "-"
    return f"{value:.3f}{'!' if value > flagged_ratio else ''}"


def _draws(row: Mapping[str, Any]) -> str:
    notes = [f"{row[what]} {what}" for what in ("failed", "skipped") if row[what]]
    return f"{row['draws']}" + (f" ({', '.join(notes)})" if notes else "")
