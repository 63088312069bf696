"""`compare --judge`: a folder judges, a run that was killed goes on, and bad words are one sentence."""

import json
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from machine import raising
from stereorecal_field import _compare_field

import stereorecal as sr

pytest.importorskip("stereorecal_features", reason="the plug-in is not installed")
RIVALS = ("--strategies", "features,essential-matrix")
MOODY = ("--strategies", "features,moody")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A street that an ideal rig sees, with its true disparities."""
    camera = sr.Camera((240, 180), np.array([[230.0, 0, 119.5], [0, 230, 89.5], [0, 0, 1]]))
    rig = sr.StereoRig(camera, camera, np.array([0.0, 0, 0, -0.3, 0, 0]))
    scene = sr.synthetic.render("street", 1, rig=rig)
    folder = tmp_path_factory.mktemp("judge") / "street"
    sr.io.save_scene(scene, folder)
    depth = np.full((180, 240), 9.0)  # roughly: what is judged here is the plumbing
    np.savez(folder / "gt.npz", (230 * 0.3 / depth).astype(np.float32))
    told = json.loads((folder / "calib.json").read_text())
    told |= {"disparity_gt": "gt.npz", "gt_encoding": "npz arr_0 float32"}
    (folder / "calib.json").write_text(json.dumps(told))
    return folder


def test_a_folder_judges(command, folder, tmp_path):
    target, page = tmp_path / "a.json", tmp_path / "a.html"
    words = ("compare", "--judge", f"lidar={folder}", "--draws", 1, *RIVALS)
    answer = command(*words, "--json", target, "--html", page)
    assert answer.code == 0
    assert "lidar: by depths that are known" in answer.out
    assert "essential-matrix" in answer.out
    data = json.loads(target.read_text())
    assert [(row["draw"], row["method"]) for row in data["trials"]] == [
        (draw, method) for draw in (None, 0) for method in ("features", "essential-matrix")
    ]
    assert all(row["row_error_px"]["start"] is not None for row in data["trials"])
    assert "</html>" in page.read_text()
    assert command(*words, "--json", target).code == 2  # it exists


@pytest.mark.slow
def test_killed_and_resumed(command, folder, tmp_path, moody):
    target = tmp_path / "a.json"
    words = ("compare", "--judge", f"lidar={folder}", "--draws", 1, *MOODY, "--json", target)

    class Killed(BaseException):
        pass

    moody(raising(Killed))
    with pytest.raises(Killed):
        command(*words)
    moody()
    assert len(json.loads(target.read_text())["trials"]) == 1
    assert command(*words).code == 0
    assert len(json.loads(target.read_text())["trials"]) == 4


@pytest.mark.slow
def test_a_page_is_replaced_by_force_only(command, folder, tmp_path, moody):
    data, page = tmp_path / "a.json", tmp_path / "a.html"
    words = ("compare", "--judge", f"lidar={folder}", "--draws", 1, *MOODY, "--json", data, "--html", page)

    def ctrl_c(run: int) -> None:
        raise KeyboardInterrupt

    moody(ctrl_c)
    interrupted = command(*words)
    assert interrupted.code == 130
    assert f"the same command goes on from {data}, with --force" in interrupted.err
    moody()
    refused = command(*words)
    assert refused.code == 2
    assert f"--html {page}: the file exists already" in refused.err
    answer = command(*words, "--force")
    assert answer.code == 0
    assert "1 of 4 trials were finished already; going on." in answer.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.html", "a.json"]


@pytest.mark.parametrize("text", ["", "a list of trials", "{}\n", "[1]\n", '{"schema": "stereorecal.field/1"}'])
def test_another_file_is_not_continued_and_not_replaced(command, folder, tmp_path, moody, text):
    moody(raising(KeyboardInterrupt))
    (tmp_path / "a.json").write_text(text)
    words = ("compare", "--judge", f"lidar={folder}", "--draws", 1, "--strategies", "moody")
    answer = command(*words, "--json", tmp_path / "a.json")
    assert answer.code == 2
    assert "the file exists already" in answer.err
    assert (tmp_path / "a.json").read_text() == text


class Lossy(Executor):
    """Its worker dies with the second trial."""

    def __init__(self):
        self.begun = 0

    def submit(self, fn, /, *args, **kwargs):
        self.begun += 1
        future = Future()
        if self.begun == 1:
            future.set_result(fn(*args, **kwargs))
        else:
            future.set_exception(BrokenProcessPool("a process died"))
        return future


def test_a_worker_that_dies_interrupts(command, folder, tmp_path, monkeypatch):
    words = ("compare", "--judge", f"lidar={folder}", "--draws", 1, *RIVALS, "--json", tmp_path / "a.json")
    with monkeypatch.context() as patch:
        patch.setattr(_compare_field, "executor", lambda _: nullcontext(Lossy()))
        answer = command(*words)
    assert answer.code == 130
    assert "a worker was lost" in answer.err
    assert "interrupted; 1 of 4 trials were finished; the same command goes on from" in answer.err
    assert len(json.loads((tmp_path / "a.json").read_text())["trials"]) == 1
    command(*words, "--seed", 5).refuses("the file exists already")
    resumed = command(*words)
    assert resumed.code == 0
    assert "1 of 4 trials were finished already; going on." in resumed.err
    assert len(json.loads((tmp_path / "a.json").read_text())["trials"]) == 4
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]
    assert command(*words).code == 2  # it is complete


def test_help_says_what_is_in_sample(command):
    told = " ".join(command("compare", "--help").out.split())
    assert "Only rows of lidar and of motion=FOLDER are of images that methods get, too" in told


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--judge", "lidra=x"), "unknown judge 'lidra'; did you mean lidar"),
        (("--judge", "lidar=nowhere"), "nowhere: there is no such folder"),
        (("--preset", "feild"), "unknown --preset 'feild' (did you mean field?)"),
        (("--judge", "walk", "--strategies", "featurs"), "unknown method 'featurs'; did you mean features"),
        (("--judge", "walk", "--scene", "x"), "--scene belongs to comparisons of strategies"),
        (("--judge", "walk", "--free", "rotation"), "--free belongs to comparisons of strategies"),
        (("--judge", "walk", "--draws", "0"), "--draws is 0; give 1 or more"),
        (("--judge", "rendered", "--frames", "all"), "--frames all has no meaning"),
        (
            ("--judge", "rendered", "--judge", "product=x", "--frames", "1"),
            "leave it out with --judge product=x, which",
        ),
        (
            ("--preset", "field", "--judge", "lidar=x", "--frames", "3"),
            "--frames applies to the judges rendered and simulated",
        ),
        (("--judge", "boards=.", "--square", "-1"), "--square is -1.0; give metres"),
        (("--judge", "boards=.", "--square", "1", "--board-corners", "9"), "--board-corners is"),
        (("--full",), "--full needs --judge"),
        (("--judge", "walk", "--full"), "--full belongs to --preset field"),
        (("--square", "0.03"), "--square needs --judge"),
        (("--judge", "walk", "--executor", "processes:none"), "--executor is 'processes:none'"),
    ],
)
def test_bad_words(command, tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    answer = command("compare", *words, "--json", "out.json")
    assert answer.code == 2
    assert message in answer.err
    assert len(answer.err.splitlines()) == 1
    assert not list(tmp_path.iterdir())
