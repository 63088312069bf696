"""What commands do alike, whatever they work out: JSON, silence, progress, matchers, executors."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from spoiled import fog

from stereorecal.io import load_scene, save_scene

WORDS = {
    "compare": ("--schedule", "count", "--draws", 2, "--scale", 0.5, "--budget", 5, "--scene"),
    "recalibrate": ("--schedule", "count"),
    "score": (),
}
ROWS = {"compare": "trials", "recalibrate": "repairs", "score": "scenes"}
CODES = {"compare": 0, "recalibrate": 0, "score": 1}
SCHEMAS = {"compare": "compare/1", "recalibrate": "solution/3", "score": "health/4"}
each_verb = pytest.mark.parametrize("verb", WORDS)
searching = pytest.mark.parametrize("verb", ["compare", "recalibrate"])


def rows_of(command, verb: str, *words: object) -> tuple[dict, list[dict]]:
    """The JSON on stdout, on which nothing else is, and its answers."""
    answer = command(verb, *WORDS[verb], *words, "--json", "-")
    content = json.loads(answer.out)
    assert (answer.code in (0, 1), answer.err) == (True, "")
    assert content["schema"] == f"stereorecal.{SCHEMAS[verb]}"
    return content, content[ROWS[verb]]


def count_of(row: dict) -> int:
    """By the calibration that was given, or the best that is known."""
    return row.get("score_reference") or row["score_before"]["count"]


@pytest.fixture(scope="module")
def kept() -> dict[str, tuple[dict, list[dict]]]:
    """What `told` has told."""
    return {}


@pytest.fixture
def told(command, drifted_scene: Path, kept) -> Callable[[str], tuple[dict, list[dict]]]:
    """told(verb): its JSON on stdout of the drifted scene, and the answers in it."""

    def once(verb: str) -> tuple[dict, list[dict]]:
        if verb not in kept:
            kept[verb] = rows_of(command, verb, drifted_scene)
        return kept[verb]

    return once


@each_verb
def test_json_on_stdout_is_what_a_file_would_hold(told, command, drifted_scene: Path, tmp_path: Path, terminal, verb):
    """Each command says nothing in a quiet run, also on a terminal; the exit code tells."""
    target, (content, rows) = tmp_path / "out.json", told(verb)
    terminal("stderr")
    answer = command(verb, *WORDS[verb], drifted_scene, "--quiet", "--json", target)
    assert (answer.code, answer.out, answer.err) == (CODES[verb], "", "")
    stored = json.loads(target.read_text())
    assert stored["settings"] == content["settings"]
    assert [{**row, "seconds": None} for row in stored[ROWS[verb]]] == [{**row, "seconds": None} for row in rows]
    assert len(rows) == (2 if verb == "compare" else 1)
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.slow(after=1)
@searching
def test_progress_only_on_a_terminal(command, drifted_scene: Path, terminal, verb: str):
    terminal("stderr")
    answer = command(verb, *WORDS[verb], drifted_scene)
    assert "repairing" in answer.err
    assert "repairing" not in answer.out
    terminal("stderr", False)
    answer = command(verb, *WORDS[verb], drifted_scene)
    assert answer.err == ""
    assert answer.out


@pytest.mark.slow(after=1)
@each_verb
def test_matchers(told, command, drifted_scene: Path, verb: str):
    both = {"sad": told(verb), "bm": rows_of(command, verb, drifted_scene, "--matcher", "bm")}
    for name, (content, _) in both.items():
        assert content["settings"]["matcher"]["name"] == name
    for row, other in zip(*(rows for _, rows in both.values()), strict=True):
        assert count_of(row) != count_of(other)
        assert min(count_of(row), count_of(other)) > 500


# --- rigs x spoilings x doors -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def recordings(clean_scene: Path, drifted_scene: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Recordings of a good rig, of one that has drifted, of fog, and one whose right images are upside down."""
    folder, scene = tmp_path_factory.mktemp("spoiled"), load_scene(clean_scene)
    (pair,) = scene.pairs
    upside_down = replace(pair, right=pair.right[::-1, ::-1].copy(), origin=None)
    for name, spoiled in (("fog", fog(pair.size)), ("mixed", upside_down)):
        save_scene(replace(scene, pairs=(spoiled,)), folder / name)
    return {"clean": clean_scene, "drifted": drifted_scene, "fog": folder / "fog", "mixed": folder / "mixed"}


ENDS = {  # of `score`, and of `recalibrate`; None: it cannot be used
    "clean": ("healthy", "already_good"),
    "drifted": ("repair", "improved"),
    "fog": ("cannot_tell", "too_little_texture"),
    "mixed": (None, None),
}


@pytest.mark.parametrize(
    ("names", "codes"),
    [
        pytest.param(("drifted", "clean"), (1, 0), marks=pytest.mark.slow),
        pytest.param(("clean", "fog"), (4, 4), marks=pytest.mark.slow),
        pytest.param(("fog", "fog"), (4, 4), marks=pytest.mark.slow),  # the same name
        (("fog", "drifted", "clean"), (1, 4)),  # an alarm is more urgent than none; a repair is none
        (("clean", "mixed", "fog"), (2, 2)),
    ],
)
@pytest.mark.parametrize("verb", ["score", "recalibrate"])
def test_the_worst_of_several_decides_and_takes_no_other_with_it(
    command, recordings: dict[str, Path], tmp_path: Path, verb: str, names: tuple[str, ...], codes: tuple[int, int]
):
    door, target = ("score", "recalibrate").index(verb), tmp_path / "out.json"
    how = ("--executor", "threads:2") if verb == "recalibrate" else ()
    answer = command(verb, *(recordings[name] for name in names), *how, "--json", target)
    rows = json.loads(target.read_text())[ROWS[verb]]
    assert answer.code == codes[door]
    assert [row.get(("condition", "reason")[door]) for row in rows] == [ENDS[name][door] for name in names]
    for row in rows:
        if row.get("reason") == "already_good":
            assert (row["accepted"], row["extrinsics"]["used"]) == (False, row["extrinsics"]["before"])
    assert ["upside down" in (row["error"] or "") for row in rows] == [name == "mixed" for name in names]
    assert answer.err.count("\n") == answer.err.count("upside down") == names.count("mixed")
    told = [name if names.count(name) == 1 else str(recordings[name])[:20] for name in names]  # folders, if equal
    assert all(name in answer.out for name in told)
    assert "NaN" not in target.read_text()
