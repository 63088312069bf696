"""The files of a reproduction: JSON, CSV and figures."""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal.io import json_text, make_folder, write_bytes, write_text
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.recordings import Log, names_of
from stereorecal.scoring.host import disparity, rectify
from stereorecal_paper._pixel_counter import counter_of
from stereorecal_paper._reproduce import Reproduction

Row = Mapping[str, Any]
_SUFFIXES = ("png", "pdf")


def write_files(found: Reproduction, log: Log, folder: Path) -> list[Path]:
    """Write a JSON and a CSV file of each experiment, and its figure as PNG and PDF; each file whole or not at all.

    Needs matplotlib. Returns what was written.

    Raises:
        InputError: if the place cannot be written to.
    """
    from stereorecal_paper._figures import experiment_figures

    data, texts = found.as_dict(), {}
    for name, rows in data["rows"].items():
        alone = {**data, "summary": data["summary"].get(name), "rows": rows}
        texts[f"{name}.json"] = json_text(alone)
        for stem, lines in _flat_rows(name, rows).items():
            if lines:
                texts[f"{stem}.csv"] = _csv(lines)
    figures = experiment_figures(data["rows"]) | _disparities(data, log, found.matcher)
    make_folder(folder)
    for name, text in texts.items():
        write_text(folder / name, text)
    for name, figure in figures.items():
        for suffix in _SUFFIXES:
            image = io.BytesIO()
            figure.savefig(image, format=suffix, dpi=110)
            write_bytes(folder / f"{name}.{suffix}", image.getvalue())
    return [folder / name for name in (*texts, *(f"{figure}.{suffix}" for figure in figures for suffix in _SUFFIXES))]


def _disparities(data: Mapping[str, Any], log: Log, matcher: AbstractMatcher) -> dict[str, Any]:
    """The figure of disparities before and after, of the first pair without a star (paper, figure 7)."""
    from stereorecal_paper._figures import disparity_figure

    rows = [row for row in data["rows"].get("ex_nihilo", ()) if not row["starred"]]
    if not rows:
        return {}
    first = rows[0]
    same = [row for row in rows if (row["sequence"], row["image"]) == (first["sequence"], first["image"])]
    mission = next(mission for mission in log.missions if mission.name == first["sequence"])
    pair = mission.pairs[names_of(mission.pairs).index(first["image"])]
    counter = counter_of(log, mission, Reach(**data["settings"]["reach"]), matcher)
    calibrations = {"from nothing": first["extrinsics"]["start"]}
    calibrations |= {f"after, {row['schedule']}": row["extrinsics"]["found"] for row in same}
    calibrations |= {"manual": counter.rig.extrinsics}
    panels = {}
    for name, extrinsics in calibrations.items():
        rig = counter.rig.with_extrinsics(np.array(extrinsics))
        found = disparity(rig, pair, matcher=counter.matcher, view=counter.view)
        panels[name] = np.asarray(found.values), np.asarray(found.valid)
    left, _ = rectify(counter.rig, pair, view=counter.view)
    return {"ex_nihilo_disparity": disparity_figure(left, panels)}


def _flat_rows(name: str, rows: Sequence[Row]) -> dict[str, list[dict[str, Any]]]:
    """Rows of plain cells by the stem of a file; the points of sweeps, ways and sequences have lines of their own."""
    if name == "sweeps":
        points = [
            {**_plain(row), "offset": offset, "count": count}
            for row in rows
            for offset, count in zip(row["offsets"], row["counts"], strict=True)
        ]
        return {name: points}
    if name == "sequential":
        steps = [({**_plain(row), "step": index}, step) for row in rows for index, step in enumerate(row["steps"], 1)]
        return {
            name: [{**about, **_plain(step)} for about, step in steps],
            f"{name}_way": [
                {**about, "image": step["image"], **point} for about, step in steps for point in step["way"]
            ],
        }
    ways = [
        {**{key: row[key] for key in ("sequence", "image", "calibration", "schedule")}, **point}
        for row in rows
        for point in row.get("way", ())
    ]
    return {name: [_plain(row) for row in rows], f"{name}_way": ways}


def _plain(row: Row) -> dict[str, Any]:
    """Numbers and words, those of mappings under "key.name"; lists are left out."""
    return dict(_pairs("", row))


def _pairs(prefix: str, row: Row) -> Iterator[tuple[str, Any]]:
    for key, value in row.items():
        if isinstance(value, Mapping):
            yield from _pairs(f"{prefix}{key}.", value)
        elif not isinstance(value, list):
            yield f"{prefix}{key}", value


def _csv(lines: Sequence[Mapping[str, Any]]) -> str:
    columns = list(dict.fromkeys(key for line in lines for key in line))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    return text.getvalue()
