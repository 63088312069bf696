"""What is written: never over an input, nor over another file unasked; what fails costs no other, and is printed."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bags import write_bag
from machine import at_call, full_disk, raising

from stereorecal.io import back_up, save_rig
from stereorecal.synthetic import default_rig

COUNT = ("--schedule", "count")  # improves the drifted scene
VERBS = {
    "score": ("score", "{0}"),
    "diff": ("diff", "{0}", "{0}"),
    "recalibrate": ("recalibrate", "{0}", *COUNT),
    "compare": ("compare", "--scene", "{0}", "--draws", 1, "--budget", 1, *COUNT),
    "monitor": ("monitor", "{0}", "--once"),
}
OPTIONS = [(verb, "--json") for verb in VERBS] + [
    ("recalibrate", "--output"),
    ("recalibrate", "--maps"),
    ("compare", "--html"),
    ("monitor", "--output"),
]


def words(verb: str, scene: Path) -> list[object]:
    return [word.format(scene) if isinstance(word, str) else word for word in VERBS[verb]]


def state(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# Each command says what it reads; how a file is told from another is the same for all.
REPLACING = [
    *((verb, option, force, "calib.json") for verb, option in OPTIONS for force in (True, False)),
    *((verb, option, True, "left.png") for verb, option in OPTIONS if verb != "diff"),
    *(("recalibrate", "--output", force, name) for force in (True, False) for name in ("link", "hard link", "own")),
]
KEPT = [("recalibrate", "--output", True, name) for name in ("calib.json", "link")]  # a copy of which is kept


@pytest.mark.parametrize(("verb", "option", "force", "name"), [one for one in REPLACING if one not in KEPT])
def test_no_input_is_replaced(command, folder: Path, tmp_path: Path, verb: str, option: str, force: bool, name: str):
    (folder / "link").symlink_to("calib.json")
    (folder / "hard link").hardlink_to(folder / "calib.json")
    (folder / "own").symlink_to("own")
    before = state(tmp_path)
    answer = command(*words(verb, folder), option, folder / name, *(["--force"] if force else []))
    said = "cannot be written there" if name == "own" else "will not be overwritten" if force else "--force"
    answer.refuses("maps are written as .npz" if "maps are written as .npz" in answer.err else said)
    assert state(tmp_path) == before


@pytest.mark.parametrize("option", ["--json", "--output", "--maps"])
def test_what_else_is_read(command, clean_scene: Path, tmp_path: Path, option: str, unworked):
    """A table of ranges and a calibration that lies elsewhere are inputs as well."""
    ranges, calibration = tmp_path / "ranges.npz", tmp_path / "calibration.json"
    ranges.write_text("pair,column,row,metres,sigma\nleft.png,80,60,10,\n")
    save_rig(default_rig().resized((160, 120)), calibration)
    before = state(tmp_path)
    sides = (f"--left={clean_scene}/left.png", f"--right={clean_scene}/right.png")
    for path in (ranges, calibration):
        given = ("--calibration", calibration, "--ranges", ranges, option, path, "--force")
        command("recalibrate", *sides, *unworked, *given).refuses()
    assert state(tmp_path) == before


def test_all_files_of_a_bag_are_inputs(command, clean_scene: Path, tmp_path: Path):
    pytest.importorskip("rosbags", reason="rosbags is not installed")
    noise = np.random.default_rng(0).integers(0, 256, (2, 120, 160), np.uint8)
    bag = write_bag(tmp_path / "bag", [("/left", 10**9, noise[0]), ("/right", 10**9, noise[1])], ros1=False)
    before = state(bag)
    assert len(before) == 2
    about = ("--bag", bag, "--left", "/left", "--right", "/right", "--calibration", clean_scene)
    for path in before:
        command("score", *about, "--json", path, "--force").refuses("will not be overwritten")
    assert state(bag) == before


MEANWHILE = {  # and what is printed in its place
    ("diff", "--json"): '"stereorecal.difference/1"',
    ("recalibrate", "--output"): '"K_left"',
    ("compare", "--html"): "compass",
    ("recalibrate", "--html"): "matched  ",
}


@pytest.mark.parametrize(("verb", "option"), MEANWHILE)
def test_a_file_that_another_run_has_written_meanwhile(
    command, drifted_scene: Path, tmp_path: Path, verb: str, option: str
):
    """It stays, and the result is not lost."""
    target = tmp_path / "out.json"
    with at_call("fsync", lambda _: target.write_text("theirs")):
        answer = command(*words(verb, drifted_scene), option, target)
    assert (answer.code, target.read_text()) == (2, "theirs")
    assert "the file exists already" in answer.err
    assert MEANWHILE[verb, option] in answer.out


def test_no_earlier_copy_is_replaced(tmp_path: Path):
    path = tmp_path / "calib.json"
    for text, name in (("first", "calib.json.bak"), ("second", "calib.json.bak2")):
        path.write_text(text)
        assert back_up(path) == tmp_path / name
    assert [(tmp_path / f"calib.json.bak{number}").read_text() for number in ("", "2")] == ["first", "second"]


@pytest.mark.parametrize(("verb", "option"), [*OPTIONS, ("recalibrate", "--html")])
def test_another_file_is_replaced_with_force_only(
    command, folder: Path, tmp_path: Path, verb: str, option: str, moody_matcher
):
    """It is looked for before any work."""
    other = tmp_path / ("other.npz" if option == "--maps" else "other.json")
    other.write_text("mine")
    asked = (*words(verb, folder), *(("--matcher", "moody") if verb != "diff" else ()), option, other)
    moody_matcher(lambda search: pytest.fail("worked before it looked"))
    command(*asked).refuses("other.", "the file exists already; choose another or add --force")
    assert other.read_text() == "mine"
    moody_matcher()
    answer = command(*asked, "--force")
    assert answer.code in (0, 1, 4), answer.err
    unrepaired = option == "--output" and (verb == "monitor" or "not written" in answer.out)
    assert (other.read_bytes() == b"mine") is unrepaired
    assert {path.name for path in tmp_path.iterdir()} == {"scene", other.name}


def test_a_state_that_is_none_is_left_alone(command, folder: Path, tmp_path: Path):
    other = tmp_path / "state"
    other.write_text("mine")
    for path in (other, folder / "calib.json"):
        before = path.read_bytes()
        assert command("monitor", folder, "--once", "--state", path).code == 2
        assert path.read_bytes() == before


def test_a_link_that_leads_to_nothing_yet(command, clean_scene: Path, tmp_path: Path):
    """The file it names is written, and it stays a link; one into a folder that is not there is refused."""
    link, lost = tmp_path / "link.json", tmp_path / "lost.json"
    link.symlink_to("later.json")
    lost.symlink_to("nowhere/later.json")
    assert command("diff", clean_scene, clean_scene, "--json", link).code == 0
    assert link.is_symlink()
    assert json.loads((tmp_path / "later.json").read_text())["schema"] == "stereorecal.difference/1"
    command("diff", clean_scene, clean_scene, "--json", lost).refuses("cannot be written there")


@pytest.mark.parametrize(
    "asked",
    [
        ("recalibrate", "{0}", "--output", "-"),
        ("recalibrate", "{0}", "--maps", "-"),
        ("recalibrate", "{0}", "--html", "-"),
        ("recalibrate", "{0}", "--rrd", "-"),
        ("convert", "{0}", "-"),
        ("monitor", "{0}", "--output", "-"),
        ("monitor", "{0}", "--state", "-"),
    ],
    ids=" ".join,
)
def test_what_does_not_go_to_stdout(command, clean_scene: Path, tmp_path: Path, monkeypatch, asked: tuple[str, ...]):
    monkeypatch.chdir(tmp_path)
    command(*(word.format(clean_scene) for word in asked)).refuses()
    assert list(tmp_path.iterdir()) == []


# --- what cannot be written ---------------------------------------------------------------------------------


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="has no full device")
def test_a_full_disk_loses_nothing(command, drifted_scene: Path, tmp_path: Path):
    """The report and the calibration are printed, and the maps are written all the same."""
    maps = tmp_path / "maps.npz"
    full = tmp_path / "full.json"
    full.symlink_to("/dev/full")
    answer = command("recalibrate", drifted_scene, *COUNT, "--output", full, "--json", "/dev/full", "--maps", maps)
    assert answer.code == 2
    for place in ("/dev/full", full):
        assert answer.err.count(f"stereorecal: {place}: cannot be written (No space left on device)") == 1
    assert answer.err.count("\n") == 2
    assert answer.out.startswith("Repaired")
    assert '"K_left"' in answer.out
    assert '"stereorecal.solution/3"' in answer.out
    assert maps.exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="has no full device")
def test_what_finds_no_room_is_printed_and_a_watch_goes_on(command, clean_scene: Path, tmp_path: Path):
    answer = command("convert", clean_scene, "/dev/full")
    assert answer.code == 2
    assert answer.err.startswith("stereorecal: /dev/full: cannot be written (No space left on device)")
    assert '"K_left"' in answer.out
    state = tmp_path / "state"
    answer = command("monitor", clean_scene, "--once", "--json", "/dev/full", "--state", state)
    assert answer.code == 2
    assert answer.err == "stereorecal: --json /dev/full: cannot be written (No space left on device); make room.\n"
    assert "the calibration in use is the one that was given" in answer.out
    assert state.exists()


def test_json_on_stdout_stays_json(command, drifted_scene: Path, tmp_path: Path):
    """What could not be written is on stderr then."""
    with full_disk():
        answer = command("recalibrate", drifted_scene, *COUNT, "--json", "-", "--output", tmp_path / "new.json")
    assert answer.code == 2
    assert json.loads(answer.out)["schema"].startswith("stereorecal.")
    assert '"K_left"' in answer.err


def test_a_copy_of_what_is_replaced_through_a_link_is_beside_the_file(command, drifted_scene: Path, tmp_path: Path):
    """Who reads it by its own name finds the same."""
    scene, store = tmp_path / "scene", tmp_path / "store"
    shutil.copytree(drifted_scene, scene)
    store.mkdir()
    (scene / "calib.json").rename(store / "rig.json")
    (scene / "calib.json").symlink_to(store / "rig.json")
    assert command("recalibrate", scene, *COUNT, "--output", scene / "calib.json", "--force").code == 0
    assert sorted(path.name for path in store.iterdir()) == ["rig.json", "rig.json.bak"]
    assert (scene / "calib.json").is_symlink()


def test_one_that_fails_costs_no_other(command, drifted_scene: Path, tmp_path: Path):
    """Whatever the error: this one is none of a disk."""
    places = [tmp_path / "new.json", tmp_path / "out.json"]
    with at_call("fsync", raising(KeyError("a bug")), 1):
        answer = command("recalibrate", drifted_scene, *COUNT, "--output", places[0], "--json", places[1])
    assert (answer.code, answer.err.count("KeyError('a bug')")) == (3, 1)
    assert answer.out.startswith("Repaired")
    assert [place.exists() for place in places].count(True) == 1


# --- stdout -------------------------------------------------------------------------------------------------

RUN = [sys.executable, "-m", "stereorecal"]


@pytest.mark.slow(after=4)
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="has no full device")
@pytest.mark.parametrize(
    ("streams", "code"),
    [("<&- >&-", 0), ("2>&-", 0), (">&0", 0), (">/dev/full", 2), ("2>&0", 0), ("2>/dev/full", 0)],
    ids=["stdout is closed", "stderr is closed", "| head", "stdout is full", "2>&1 | head", "stderr is full"],
)
def test_streams_that_take_nothing(folder: Path, tmp_path: Path, streams: str, code: int):
    """The work is done and the file is written all the same; a disk that is full is said."""
    calibration = json.loads((folder / "calib.json").read_text())
    calibration["T"] = [100 * metres for metres in calibration["T"]]  # of which is warned
    (folder / "calib.json").write_text(json.dumps(calibration))
    target, (reads, nobody_reads) = tmp_path / "out.json", os.pipe()
    os.close(reads)
    run = ["sh", "-c", f'exec "$@" {streams}', "sh", *RUN, "diff", str(folder), str(folder), "--json", str(target)]
    ended = subprocess.run(run, stdin=nobody_reads, capture_output=True, text=True, check=False)
    os.close(nobody_reads)
    assert ended.returncode == code
    assert bool(ended.stdout) == (streams[0] == "2")
    errors = ended.stderr.splitlines()[2 if streams[0] != "2" else 0 :]  # without what is warned of
    assert [error[:37] for error in errors] == ["stereorecal: stdout: cannot be written"[:37]] * (code == 2)
    assert json.loads(target.read_text())["schema"] == "stereorecal.difference/1"


def test_control_characters_in_names_are_spelt(command, tmp_path: Path):
    command("score", tmp_path / "a\x1b[31m\nb").refuses(r"a\x1b[31m\nb")


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("extra", [{"LC_ALL": "C", "PYTHONIOENCODING": "ascii"}, {"PYTHONOPTIMIZE": "1"}])
def test_poor_surroundings(clean_scene: Path, drifted_scene: Path, extra: dict[str, str]):
    """No home, no cache that can be written, ASCII only, no assertions."""
    kept = {name: os.environ[name] for name in ("PATH", "PYTHONPATH") if name in os.environ}
    nowhere = {"HOME": "/nonexistent", "XDG_CACHE_HOME": "/proc/nowhere"}
    run = [*RUN, "diff", str(clean_scene), str(drifted_scene)]
    ended = subprocess.run(run, env=kept | nowhere | extra, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout
