"""Bad input: exit code 2, one sentence on stderr that says the thing, nothing written, nothing overwritten."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

Spoil = Callable[[Path], Any]


def refused(answer, words: str) -> None:
    assert answer.code == 2
    assert answer.out == ""
    assert answer.err.endswith("\n")
    assert answer.err.count("\n") == 1, answer.err
    assert "Traceback" not in answer.err
    assert words.lower() in answer.err.lower()


def image(path: Path) -> np.ndarray:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


def rewrite(path: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    cv2.imwrite(str(path), change(image(path)))


def calibration(**changes: Any) -> Spoil:
    """Replaces keys of calib.json; `...` removes one, a function changes one."""

    def spoil(folder: Path) -> None:
        path = folder / "calib.json"
        content = json.loads(path.read_text())
        for key, value in changes.items():
            content[key] = value(content[key]) if callable(value) else value
        path.write_text(json.dumps({key: value for key, value in content.items() if value is not ...}))

    return spoil


def cut(name: str, share: float = 0.5) -> Spoil:
    def spoil(folder: Path) -> None:
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(data[: int(share * len(data))])

    return spoil


def swap_images(folder: Path) -> None:
    (folder / "left.png").rename(folder / "x.png")
    (folder / "right.png").rename(folder / "left.png")
    (folder / "x.png").rename(folder / "right.png")


def several(folder: Path) -> None:
    """Folders with two pairs, one of which lacks its right image."""
    for side in ("left", "right"):
        (folder / side).mkdir()
        (folder / f"{side}.png").rename(folder / side / "0.png")
    (folder / "left" / "1.png").write_bytes((folder / "left" / "0.png").read_bytes())


def entry(row: int, column: int, value: float) -> Callable[[list], list]:
    def change(matrix: list) -> list:
        array = np.array(matrix)
        array[row, column] = value
        return array.tolist()

    return change


SCENES: dict[str, tuple[Spoil, str]] = {
    "no calib.json": (lambda f: (f / "calib.json").unlink(), "calib.json: there is no such file"),
    "empty calib.json": (lambda f: (f / "calib.json").write_text(""), "calib.json: the file is empty"),
    "truncated calib.json": (cut("calib.json"), "not valid JSON, or truncated"),
    "binary calib.json": (lambda f: (f / "calib.json").write_bytes(b"\xff\xfe\x00\x81"), "not a text file"),
    "calib.json is a list": (lambda f: (f / "calib.json").write_text("[1]"), "no JSON object"),
    "key missing": (calibration(K_left=...), "'K_left' is missing"),
    "no left image": (lambda f: (f / "left.png").unlink(), "there is no image left.*"),
    "no right image": (lambda f: (f / "right.png").unlink(), "there is no image right.*"),
    "no partner": (several, "left/1.png: this image has no partner on the right side"),
    "empty image": (lambda f: (f / "left.png").write_bytes(b""), "left.png: the file is empty"),
    "truncated image": (cut("right.png"), "right.png: the image is truncated"),
    "no image at all": (lambda f: (f / "left.png").write_text("hello"), "left.png: not an image"),
    "sizes differ": (
        lambda f: rewrite(f / "right.png", lambda i: i[:-8]),
        "the left image is 160x120 and the right one 160x112",
    ),
    "another size than the calibration": (
        calibration(image_size=[320, 240]),
        "the images are 160x120, but the calibration is for 320x240",
    ),
    "all black": (lambda f: rewrite(f / "left.png", np.zeros_like), "left: the image is all black"),
    "constant": (lambda f: rewrite(f / "right.png", lambda i: np.full_like(i, 77)), "right: the image is constant"),
    "NaN": (calibration(T=[float("nan"), 0, 0]), "NaN"),
    "infinity": (calibration(K_left=entry(0, 0, float("inf"))), "Infinity"),
    "singular intrinsics": (calibration(K_left=entry(0, 0, 0.0)), "left camera: the camera matrix is singular"),
    "negative intrinsics": (calibration(K_right=entry(1, 1, -150.0)), "right camera: the camera matrix is singular"),
    "zero baseline": (calibration(T=[0, 0, 0]), "the baseline is zero"),
    "no rotation": (calibration(R=entry(2, 2, -1.0)), "R is not a rotation"),
    "swapped calibration": (calibration(T=lambda t: [-v for v in t]), "left and right are swapped"),
    "swapped images": (swap_images, "look swapped"),
    "fisheye": (calibration(distortion_model="fisheye"), "distortion model 'fisheye' is not supported"),
    "odd coefficients": (calibration(D_left=[0.1, 0.2, 0.3]), "distortion of 3 coefficients is not supported"),
    "no calibration": (
        calibration(K_left=None, K_right=None, D_left=None, D_right=None, R=None, T=None),
        "the scene has no calibration",
    ),
}


@pytest.mark.parametrize(("spoil", "words"), SCENES.values(), ids=SCENES.keys())
@pytest.mark.parametrize("existing", [False, True], ids=["", "json exists"])
def test_scenes(command, folder: Path, tmp_path: Path, spoil: Spoil, words: str, existing: bool):
    spoil(folder)
    target = tmp_path / "out.json"
    if existing:
        target.write_text("precious")
    before = sorted(tmp_path.rglob("*"))
    refused(command("compare", "--scene", folder, "--json", target, "--draws", 1, "--budget", 1), words)
    assert sorted(tmp_path.rglob("*")) == before
    assert not existing or target.read_text() == "precious"


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_unreadable(command, folder: Path):
    (folder / "left.png").chmod(0)
    refused(command("compare", "--scene", folder), "left.png: cannot be read")


def test_folder_in_place_of_a_file(command, folder: Path):
    """Unreadable for everybody, root included."""
    (folder / "calib.json").unlink()
    (folder / "calib.json").mkdir()
    refused(command("compare", "--scene", folder), "calib.json: cannot be read")


def test_missing_folder(command, tmp_path: Path):
    refused(command("compare", "--scene", tmp_path / "nowhere"), "nowhere: there is no such folder")


def test_one_bad_scene_among_good_ones(command, folder: Path, clean_scene: Path):
    (folder / "left.png").unlink()
    refused(command("compare", "--scene", clean_scene, "--scene", folder), "there is no image left.*")


OPTIONS: dict[str, tuple[list[str], str]] = {
    "strategy": (["--strategies", "compas"], "unknown strategy 'compas'; did you mean compass?"),
    "one of two strategies": (["--strategies", "compass,nonsense"], "unknown strategy 'nonsense'"),
    "no strategy": (["--strategies", ","], "strateg"),
    "matcher": (["--matcher", "sgmb"], "unknown matcher 'sgmb'; did you mean sgbm?"),
    "kind of scene": (["--synthetic", "harbor"], "unknown kind of scene 'harbor'; did you mean harbour?"),
    "schedule": (["--schedule", "coarse"], "unknown schedule 'coarse'; choose one of: count"),
    "executor": (["--executor", "thread:2"], "unknown executor"),
    "workers": (["--executor", "threads:0"], "--executor is 'threads:0'"),
    "no workers": (["--executor", "processes"], "give the number of workers"),
    "frames": (["--frames", "0"], "--frames is '0'"),
    "frames word": (["--frames", "few"], "--frames is 'few'"),
    "budget zero": (["--budget", "0"], "the budget of 0.0 evaluations makes no sense"),
    "budget negative": (["--budget", "-5"], "the budget of -5.0 evaluations makes no sense"),
    "budget NaN": (["--budget", "nan"], "the budget of nan evaluations makes no sense"),
    "budget word": (["--budget", "much"], "--budget"),
    "reach zero": (["--reach", "0,0.03"], "a reach of 0.0 degrees"),
    "reach huge": (["--reach", "90,0.03"], "a reach of 90.0 degrees"),
    "reach NaN": (["--reach", "nan,0.03"], "a reach of nan degrees"),
    "reach of one number": (["--reach", "3"], "--reach is '3'; give degrees and a fraction"),
    "reach empty": (["--reach", ""], "--reach"),
    "drift negative": (["--decalibrate", "-1,0.01"], "a drift of -1.0 degrees"),
    "drift huge": (["--decalibrate", "0.5,2"], "a drift of 0.5 degrees and 2.0 of the baseline"),
    "drift word": (["--decalibrate", "a,b"], "--decalibrate is 'a,b'"),
    "scale zero": (["--scale", "0"], "scale is 0.0"),
    "scale above one": (["--scale", "1.5"], "scale is 1.5"),
    "scale NaN": (["--scale", "nan"], "scale is nan"),
    "scale too small": (["--scale", "0.05"], "at least 16 pixels"),
    "no draws": (["--draws", "0"], "at least one scene, one strategy and one draw"),
    "draws word": (["--draws", "two"], "--draws"),
    "seed": (["--seed", "-1"], "--seed is -1"),
    "seed word": (["--seed", "x"], "--seed"),
    "unknown option": (["--colour", "red"], "--colour"),
}


@pytest.mark.parametrize(("words", "said"), OPTIONS.values(), ids=OPTIONS.keys())
def test_options(command, clean_scene: Path, tmp_path: Path, words: list[str], said: str):
    target = tmp_path / "out.json"
    target.write_text("precious")
    scene = [] if "--synthetic" in words else ["--scene", clean_scene]
    # An option whose value starts with "-" needs "=".
    joined = [f"{words[0]}={words[1]}"]
    refused(command("compare", *scene, "--draws=1", "--budget=1", f"--json={target}", *joined), said)
    assert target.read_text() == "precious"


@pytest.mark.parametrize("name", ["nowhere/out.json", ""])
def test_places_that_cannot_be_written(command, clean_scene: Path, tmp_path: Path, name: str):
    refused(command("compare", "--scene", clean_scene, "--json", tmp_path / name), "cannot be written there")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", [[], ["comapre"], ["strategies", "check"], ["strategies", "check", "compas"]])
def test_commands(command, words: list[str]):
    refused(command(*words), "compass" if len(words) == 3 else "")


def test_missing_compass_gives_the_install_line(command, clean_scene: Path, monkeypatch: pytest.MonkeyPatch):
    from importlib.metadata import EntryPoints

    from stereorecal.strategies import _registry

    monkeypatch.setattr(_registry, "entry_points", lambda **_: EntryPoints())
    refused(command("compare", "--scene", clean_scene), "pip install 'stereorecal[default]'")
    refused(command("compare", "--scene", clean_scene, "--strategies", "all"), "pip install 'stereorecal[default]'")
