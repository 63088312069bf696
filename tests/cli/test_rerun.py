"""Recordings of the command line: what is refused before any work, what is written, and what is shown."""

import sys
from pathlib import Path

import pytest
from rides import Ride
from rrd_files import entities, jpeg

import stereorecal as sr
from stereorecal.io import save_scene
from stereorecal.recordings import Scene

COMMANDS = ("recalibrate", "monitor")


@pytest.fixture
def rerun():
    return pytest.importorskip("rerun", reason="rerun-sdk is not installed")


@pytest.mark.parametrize(
    ("verb", "words"), [*((verb, ("--rrd", "{}/out.rrd")) for verb in COMMANDS), ("monitor", ("--show",))]
)
def test_without_the_extra(command, clean_scene: Path, tmp_path: Path, monkeypatch, verb: str, words: tuple[str, ...]):
    monkeypatch.setitem(sys.modules, "rerun", None)
    for name in [name for name in sys.modules if name.startswith("stereorecal.report.")]:
        monkeypatch.delitem(sys.modules, name)
    answer = command(verb, clean_scene, *(word.format(tmp_path) for word in words))
    answer.refuses(f"{words[0]} needs rerun, which is not installed; run: pip install 'stereorecal[rerun]'\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("rerun")
def test_there_is_no_screen(command, clean_scene: Path, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    command("monitor", clean_scene, "--show").refuses("no screen for Rerun's viewer (DISPLAY is not set)")


@pytest.mark.usefixtures("rerun")
def test_a_repair_is_recorded(command, clean_scene: Path, tmp_path: Path):
    target = tmp_path / "out.rrd"
    answer = command("recalibrate", clean_scene, "--rrd", target)
    assert (answer.code, answer.err) == (0, "")
    found = entities(target)
    assert jpeg(found["/before/pair"]).shape[1] == 2 * jpeg(found["/after/row_error"]).shape[1]
    assert [path.name for path in tmp_path.iterdir()] == ["out.rrd"]


@pytest.mark.usefixtures("rerun")
def test_a_recording_is_whole_or_not_at_all(command, clean_scene: Path, tmp_path: Path, monkeypatch):
    """What breaks while it is made leaves the old file, and the report is printed all the same."""
    (target := tmp_path / "out.rrd").write_text("old")

    def broken(stream, report):
        stream.log("verdict", __import__("rerun").TextDocument("half"), static=True)
        raise OSError("no room")

    monkeypatch.setattr("stereorecal.report.repair_recording.log_repair", broken)
    answer = command("recalibrate", clean_scene, "--schedule", "count", "--rrd", target, "--force")
    assert answer.code != 0
    assert "matched" in answer.out
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out.rrd"]


def test_the_viewer_is_opened(rerun, command, clean_scene: Path, monkeypatch):
    """Also where PATH does not have it: an environment that is not activated."""
    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(rerun, "spawn", lambda **options: opened.append(options))
    answer = command("monitor", clean_scene, "--once", "--show")
    assert (answer.code, answer.err, len(opened)) == (0, "", 1)
    assert Path(opened[0]["executable_path"]).is_file()


def test_a_viewer_that_does_not_start(rerun, command, clean_scene: Path, monkeypatch):
    def broken(**options):
        raise RuntimeError("no executable\nlong advice")

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(rerun, "spawn", broken)
    command("monitor", clean_scene, "--once", "--show").refuses("does not start (no executable)")


@pytest.mark.usefixtures("rerun")
def test_a_watch_is_recorded(command, drive: Ride, tmp_path: Path):
    """The interval of each axis after each pair, and what happened."""
    folder, target = tmp_path / "ride", tmp_path / "watch.rrd"
    save_scene(
        Scene("ride", drive.rig, tuple(sr.Pair(p.left, p.right, f"{i}.png") for i, p in enumerate(drive.pairs))), folder
    )
    answer = command("monitor", folder, "--once", "--rrd", target, "--quiet")
    assert (answer.out, answer.err) == ("", "")
    found = entities(target)
    for name in ("pitch", "yaw", "roll", "y", "z", "epipolar_error"):
        assert sorted(found[f"/{name}"]["pair"]) == list(range(len(drive.pairs)))
        value, low, high = found[f"/{name}"]["Scalars:scalars"][-1]
        assert low < value < high
    assert any("knocked" in text for (text,) in found["/events"]["TextLog:text"])
