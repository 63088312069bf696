"""`monitor` on a short recording with a knock: events as lines and as JSON lines, exit codes, what is written."""

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest
from rides import BEFORE, Ride, standing_at

import stereorecal as sr
from stereorecal.io import save_scene
from stereorecal.online import Config, load, reading, run, save
from stereorecal.recordings import Scene


@pytest.fixture(scope="module")
def scene(drive: Ride, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scenes") / "ride"
    pairs = tuple(replace(pair, name=f"{i:03d}.png") for i, pair in enumerate(drive.pairs))
    save_scene(Scene("ride", drive.rig, pairs), folder)
    return folder


def test_a_knock_is_repaired_and_written_where_told(command, scene: Path, drive: Ride, tmp_path: Path):
    repaired, log, state = tmp_path / "repaired.json", tmp_path / "log.jsonl", tmp_path / "state"
    before = (scene / "calib.json").read_bytes()
    answer = command("monitor", scene, "--output", repaired, "--json", log, "--state", state)
    assert answer.err == ""
    assert answer.code in (0, 4)
    assert "the rig has been knocked" in answer.out
    assert f"written to {repaired}" in answer.out
    assert (scene / "calib.json").read_bytes() == before
    told = [json.loads(line) for line in log.read_text().splitlines()]
    assert {line["schema"] for line in told} == {"stereorecal.events/1"}
    assert {"knock", "repaired", "reading"} <= {line["event"] for line in told}
    assert sum(line["event"] == "reading" for line in told) == len(drive.pairs)
    apart = abs(sr.io.load_rig(repaired).extrinsics - drive.knocked.extrinsics)[0]
    assert apart < 0.001 < abs(drive.rig.extrinsics - drive.knocked.extrinsics)[0]
    assert load(state).frame == len(drive.pairs)


def test_each_camera_has_a_file(command, scene: Path, drive: Ride, tmp_path: Path):
    """The watch is continued where the calibration in use is a repaired one already."""
    old, new = ([tmp_path / f"{side}-{age}.yaml" for side in ("left", "right")] for age in ("old", "new"))
    sr.io.save_rig(drive.rig, old, format="ros")
    *_, last = run(sr.io.load_rig(*old), drive.pairs)
    save(last.state, tmp_path / "state")
    images = ("--left", scene / "left", "--right", scene / "right", "--calibration", *old)
    both = ",".join(map(str, new))
    answer = command("monitor", *images, "--pairs", 10, "--state", tmp_path / "state", "--output", both)
    assert answer.out.endswith(f"written to {both}\n")
    repaired = sr.io.load_rig(*new)
    assert abs(repaired.extrinsics - drive.knocked.extrinsics)[0] < 0.001


def test_options_are_kept_with_the_state(command, scene: Path, tmp_path: Path):
    """Cameras with a trigger have no delay; tolerances are those of the decision."""
    options = ("--synchronous", "--tolerances", "distances=3:8", "--limit", "2", "--quiet")
    assert command("monitor", scene, *options, "--state", tmp_path / "state").code in (0, 1, 4)
    state = load(tmp_path / "state")
    assert state.config.synchronous
    assert state.estimate.of_delay == 0.0
    assert state.config.tolerances.distances == (3.0, 8.0)


def test_what_is_not_said_is_as_in_the_state(command, scene: Path, drive: Ride, tmp_path: Path):
    *_, last = run(drive.rig, drive.pairs[:1], Config(prior="exact", every=2, tolerances=sr.Tolerances(harm=0.01)))
    save(last.state, tmp_path / "state")
    words = ("--once", "--quiet", "--pairs", "1:2", "--state", tmp_path / "state")
    assert command("monitor", scene, *words).code in (0, 1, 4)
    config = load(tmp_path / "state").config
    assert (config.prior, config.every, config.tolerances.harm, config.repair) == ("exact", 2, 0.01, False)


def test_once_checks_and_changes_nothing(command, scene: Path):
    answer = command("monitor", scene, "--once", "--quiet", "--pairs", f"{BEFORE - 2}:{BEFORE + 3}")
    assert (answer.code, answer.out) == (1, "")
    piped = command("monitor", scene, "--once", "--json", "-", "--pairs", ":2")
    assert [json.loads(line)["event"] for line in piped.out.splitlines()][-1] == "reading"


def test_a_pair_that_cannot_be_read_is_an_event_and_the_watch_goes_on(command, scene: Path, tmp_path: Path):
    broken, state = Path(shutil.copytree(scene, tmp_path / "ride")), tmp_path / "state"
    image = broken / "left" / "002.png"
    image.write_bytes(image.read_bytes()[:100])
    answer = command("monitor", broken, "--once", "--pairs", ":4", "--state", state, "--output", tmp_path / "new.json")
    assert "2  the pair cannot be used" in answer.out
    assert "002.png: the image is truncated" in answer.out
    assert f"the calibration in use is the one that was given; {tmp_path / 'new.json'} is not written" in answer.out
    assert not (tmp_path / "new.json").exists()
    assert load(state).frame == 4


def test_what_would_tell_is_said_where_nothing_can_be_told(command, scene: Path, tmp_path: Path):
    grey = Path(shutil.copytree(scene, tmp_path / "grey"))
    noise = np.random.default_rng(0)
    for image in sorted(grey.glob("*/*.png")):
        shape = cv2.imread(str(image), cv2.IMREAD_GRAYSCALE).shape
        cv2.imwrite(str(image), noise.integers(127, 130, shape).astype(np.uint8))
    answer = command("monitor", grey, "--once", "--pairs", ":2")
    assert answer.code == 4
    assert answer.out.count("next: turn the rig towards something with texture") == 1
    assert "px with 95 %); the calibration in use is" in answer.out


def test_every_pair_of_a_long_recording_is_watched(command, scene: Path, tmp_path: Path):
    """Other commands choose some of more than a hundred, which they use together."""
    dark, state, many = tmp_path / "dark", tmp_path / "state", 101
    for seed, side in enumerate(("left", "right")):
        (dark / side).mkdir(parents=True)
        noise = np.random.default_rng(seed).integers(0, 2, (240, 320), np.uint8)
        cv2.imwrite(str(dark / side / "000.png"), noise)
        for number in range(1, many):
            (dark / side / f"{number:03d}.png").hardlink_to(dark / side / "000.png")
    shutil.copy(scene / "calib.json", dark)
    command("monitor", dark, "--once", "--quiet", "--state", state)
    assert load(state).frame == many


def test_nobody_reads_on(scene: Path, tmp_path: Path):
    """`| head`: no complaint, and the state is kept all the same."""
    words = ("monitor", scene, "--once", "--pairs", ":2", "--state", tmp_path / "state")
    run = [sys.executable, "-m", "stereorecal", *map(str, words)]
    with subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait() in (0, 1, 4)
    assert load(tmp_path / "state").frame == 2


def test_a_watch_that_goes_on(command, scene: Path, tmp_path: Path):
    """Events are appended to those of before; pairs are counted on."""
    log, state = tmp_path / "log.jsonl", tmp_path / "state"
    words = ("monitor", scene, "--once", "--quiet", "--pairs", ":2", "--state", state, "--json", log)
    for _ in range(2):
        assert command(*words).code in (0, 1, 4)
    readings = [line for line in map(json.loads, log.read_text().splitlines()) if line["event"] == "reading"]
    assert [line["frame"] for line in readings] == [0, 1, 2, 3]
    with open(log, "a") as file:
        file.write('{"schema": "stereorecal.ev')  # the power failed
    assert command(*words).code in (0, 1, 4)
    told = log.read_text().splitlines()
    assert [json.loads(line)["frame"] for line in told if line.endswith("}") and '"reading"' in line] == list(range(6))
    log.write_text("something else\n")
    refused = command(*words)
    assert (refused.code, log.read_text()) == (2, "something else\n")
    log.write_text("")
    assert command(*words, "--force").code in (0, 1, 4)
    assert command(*words[:-4], "--json", log).code == 2  # without a state nothing goes on


def test_a_watch_that_ends_before_its_first_pair_leaves_no_log(command, moody_matcher, scene: Path, tmp_path: Path):
    log = tmp_path / "log.jsonl"

    def interrupt(search: int) -> None:
        raise KeyboardInterrupt

    moody_matcher(interrupt)
    answer = command("monitor", scene, "--once", "--matcher", "moody", "--json", log)
    assert (answer.code, log.exists()) == (130, False)
    assert "interrupted after 0 pairs" in answer.err


def test_a_log_that_appears_meanwhile_stays(command, moody_matcher, scene: Path, tmp_path: Path):
    log, state = tmp_path / "log.jsonl", tmp_path / "state"
    moody_matcher(lambda search: log.write_text("theirs"))
    answer = command("monitor", scene, "--once", "--matcher", "moody", "--pairs", 0, "--json", log, "--state", state)
    assert (answer.code, log.read_text(), state.exists()) == (2, "theirs", True)
    assert answer.err == f"stereorecal: --json {log}: a file has appeared there; choose another or add --force.\n"


def test_a_new_calibration_is_not_watched_with_an_old_state(command, scene: Path, tmp_path: Path):
    recalibrated, state = Path(shutil.copytree(scene, tmp_path / "ride")), tmp_path / "state"
    command("monitor", f"{scene}+{recalibrated}").refuses("folders are watched one after the other")
    words = ("--once", "--quiet", "--pairs", 0, "--state", state)
    assert command("monitor", scene, *words).code in (0, 1, 4)
    kept = state.read_bytes()
    content = json.loads((recalibrated / "calib.json").read_text())
    content["K_left"][0][0] *= 1.1
    (recalibrated / "calib.json").write_text(json.dumps(content))
    answer = command("monitor", recalibrated, *words)
    answer.refuses("belongs to another calibration than the given one; name another file")
    command("monitor", scene, recalibrated).refuses("one rig is watched at a time; give one scene")
    assert state.read_bytes() == kept


def test_the_live_view_shows_axes_and_events(command, terminal, scene: Path, monkeypatch: pytest.MonkeyPatch):
    terminal("stdout")
    monkeypatch.setenv("COLUMNS", "110")
    shown = command("monitor", scene, "--once", "--pairs", ":5").out
    for word in ("pitch", "yaw", "epipolar error", "depth at 11 m", "late by", "95 % interval", "fits the images"):
        assert word in shown
    for word in ("Next: ", "not determined yet: ", "matches so far", "within 2.5 m", "farther than 20 m"):
        assert word in shown


def test_until_sure_it_ends_when_the_answer_stands(command, scene: Path, tmp_path: Path):
    answer = command("monitor", scene, "--once", "--until-sure", "--state", tmp_path / "state")
    assert answer.code == 0
    assert load(tmp_path / "state").frame <= BEFORE  # the knock
    steps = [line.partition("next: ")[2] for line in answer.out.splitlines() if "next: " in line]
    assert steps[-1] == "nothing: the answer stands"
    assert all(one != other for one, other in pairwise(steps))  # said when it changes
    early = command("monitor", scene, "--once", "--until-sure", "--pairs", ":1")
    assert (early.code, early.err.count("\n")) == (4, 1)
    assert "the recording ended, after 1 pair, before this was sure; not determined: " in early.err
    assert command("monitor", scene, "--once", "--until-sure", "--pairs", ":1", "--quiet").err == ""


@pytest.mark.parametrize("yaw", [3.0, -3.0])
def test_the_live_view_of_depth_beyond_infinity(
    command, terminal, drive: Ride, scene: Path, tmp_path: Path, yaw: float
):
    """A yaw of 2 degrees is the disparity of 30 baselines. One pair alone does not prove that the state is wrong."""
    terminal("stdout")
    *_, last = run(drive.rig, drive.pairs[:2], Config())
    far = np.array([0.0, yaw, 0.0, 0.0, 0.0])
    beyond = last.state.replace(estimate=standing_at(last.state, far, 1e-4 * np.eye(5)))
    assert json.loads(json.dumps(reading(beyond).as_dict()))["condition"] in ("repair", "cannot_tell")
    save(beyond, tmp_path / "state")
    answer = command("monitor", scene, "--once", "--pairs", 0, "--state", tmp_path / "state")
    assert answer.code in (1, 4)
    assert "depth at 11 m" in answer.out
