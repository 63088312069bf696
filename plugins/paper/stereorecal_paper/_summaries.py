"""Summaries of the rows of each experiment."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from stereorecal_paper._published import Published

Row = Mapping[str, Any]


def ratio(row: Row) -> float:
    """The paper's r = N_o / N_GT; NaN where nothing matches under the reference."""
    return row["score_final"] / row["score_reference"] if row["score_reference"] else float("nan")


def of_ratios(ratios: Sequence[float]) -> dict[str, Any]:
    """How many there are, their median, and the shares that reach 1 and 0.99 and 0.98."""
    known = np.array([value for value in ratios if np.isfinite(value)])
    shares = {f"share_r_{least:g}": float(np.mean(known >= least)) if len(known) else None for least in (1, 0.99, 0.98)}
    return {"rows": len(ratios), "r_median": float(np.median(known)) if len(known) else None, **shares}


def of_published(rows: Sequence[Published]) -> dict[str, Any]:
    """The paper's own rows that are not starred, as `of_repairs` has ours."""
    return {"schedule": "the paper", **of_ratios([row.ratio for row in rows if not row.starred])}


def of_repairs(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """One summary for each schedule, of the rows that are not starred, with median errors; how starred ones end."""
    found = []
    for schedule, group in grouped_by(rows, "schedule").items():
        expected = [row for row in group if not row["starred"]]
        starred = [row for row in group if row["starred"]]
        found.append(
            {
                "schedule": schedule,
                **of_ratios([ratio(row) for row in expected]),
                "rotation_error_deg_median": _medians(expected, "rotation_error_deg"),
                "translation_error_percent_median": _medians(expected, "translation_error_percent"),
                "seconds_median": _median([row["seconds"] for row in expected]),
                "starred": len(starred),
                "starred_refused": sum(not row["accepted"] for row in starred),
                "starred_worse": sum(is_worse(row) for row in starred),
            }
        )
    return found


def is_worse(row: Row) -> bool:
    """Whether a repair was accepted although an angle is farther from the reference than before, by more than 0.02°."""
    before, after = row["start_error"]["rotation_error_deg"], row["rotation_error_deg"]
    return row["accepted"] and any(after[axis] > before[axis] + 0.02 for axis in after)


def of_validity(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """For each sequence: on how many pairs without a star the calibration that holds has the highest count, alone, and
    what share of it the best other one reaches."""
    found = []
    for sequence, group in grouped_by(rows, "sequence").items():
        expected = [row for row in group if not row["starred"]]
        own = [row["counts"][row["own"]] for row in expected]
        best = [max(n for name, n in row["counts"].items() if name != row["own"]) for row in expected]
        found.append(
            {
                "sequence": sequence,
                "calibration": group[0]["own"],
                "pairs": len(expected),
                "own_highest": sum(mine > other for mine, other in zip(own, best, strict=True)),
                "next_best_share": sum(best) / sum(own) if sum(own) else None,
            }
        )
    return found


def of_sweeps(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """For each axis and matcher: where the peak lies, over which width more than half of its count remains, and over
    which 99 %. Medians over the pairs; degrees, or percent of the baseline. `half_cut`: the sweep ends before half of
    the count is lost, the width is that of the sweep there."""
    found = []
    for (axis, matcher), group in grouped_by(rows, "axis", "matcher").items():
        shapes = np.array([_shape(row["offsets"], row["counts"]) for row in group])
        offset, half, flat = np.median(shapes, axis=0).tolist()
        cut = any(2 * max(row["counts"][0], row["counts"][-1]) >= max(row["counts"]) for row in group)
        widths = {"half_width": half, "half_cut": cut, "flat_width": flat}
        found.append({"axis": axis, "matcher": matcher, "peak": offset, **widths})
    return found


def of_generalisation(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """For each start and schedule: r on the pair that was optimised, and on the others without a star before and after
    (medians)."""
    found = []
    for row in rows:
        expected = [other for other in row["others"].values() if other["score_reference"] and not other["starred"]]
        before, after = (
            [other[when] / other["score_reference"] for other in expected] for when in ("score_initial", "score_final")
        )
        found.append(
            {
                "calibration": row["calibration"],
                "schedule": row["schedule"],
                "start_error_deg": max(row["start_error"]["rotation_error_deg"].values()),
                "r": ratio(row),
                "r_others_before": _median(before),
                "r_others_after": _median(after),
                "improved": sum(b < a for b, a in zip(before, after, strict=True)),
                "others": len(after),
            }
        )
    return found


def of_sequences(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """For each order and schedule: r after the first pair without a star, after the last, and how the rig ends."""
    found = []
    for row in rows:
        ratios = [ratio(step) for step in row["steps"] if not step["starred"]]
        found.append(
            {
                "order": row["order"],
                "schedule": row["schedule"],
                "steps": len(row["steps"]),
                "r_first": ratios[0] if ratios else None,
                "r_last": ratios[-1] if ratios else None,
                "r_median": _median(ratios),
                "accepted": sum(step["accepted"] for step in row["steps"]),
                "rotation_error_deg": row["rotation_error_deg"],
                "translation_error_percent": row["translation_error_percent"],
                "seconds": row["seconds"],
            }
        )
    return found


def _shape(offsets: Sequence[float], counts: Sequence[int]) -> tuple[float, float, float]:
    """Offset of the peak, width at half its height, width where it loses less than 1 %."""
    x, y = np.array(offsets), np.array(counts, float)
    return float(x[np.argmax(y)]), _width(x, y, 0.5 * y.max()), _width(x, y, 0.99 * y.max())


def _width(x: np.ndarray, y: np.ndarray, level: float) -> float:
    """How long y stays above a level on both sides of its peak; as far as x goes where it never falls."""
    top = int(np.argmax(y))
    ends = []
    for side in (range(top, len(x)), range(top, -1, -1)):
        below = next((i for i in side if y[i] < level), None)
        if below is None:
            ends.append(x[side[-1]])
            continue
        inner = below - side.step
        ends.append(x[inner] + (x[below] - x[inner]) * (y[inner] - level) / (y[inner] - y[below]))
    return float(ends[0] - ends[1])


def grouped_by(rows: Iterable[Row], *keys: str) -> dict[Any, list[Row]]:
    """The rows by the value under a key, or by the tuple of values under several keys; in order of appearance."""
    groups: dict[Any, list[Row]] = {}
    for row in rows:
        found = tuple(row[key] for key in keys)
        groups.setdefault(found if len(keys) > 1 else found[0], []).append(row)
    return groups


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if len(values) else None


def _medians(rows: Sequence[Row], key: str) -> dict[str, float] | None:
    return {axis: float(np.median([row[key][axis] for row in rows])) for axis in rows[0][key]} if rows else None
