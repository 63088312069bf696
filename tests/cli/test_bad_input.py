"""Bad input: exit code 2, one sentence on stderr that says the thing, nothing written, nothing overwritten."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

Spoil = Callable[[Path], Any]


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


def a_folder(folder: Path) -> None:
    (folder / "calib.json").unlink()
    (folder / "calib.json").mkdir()


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
    "unknown lens": (calibration(distortion_model="fov"), "distortion model 'fov' is not supported"),
    "odd coefficients": (
        calibration(D_left=[0.1, 0.2, 0.3]),
        "distortion has 3 coefficients; this lens model takes others",
    ),
    "another folder": (shutil.rmtree, "there is no such folder"),
    "folder in place of a file": (a_folder, "calib.json: cannot be read"),  # unreadable for root, too
    "no calibration": (
        calibration(K_left=None, K_right=None, D_left=None, D_right=None, R=None, T=None),
        "the scene has no calibration",
    ),
}


FAST = {
    "compare": ("--draws=1", "--budget=1"),
    "recalibrate": ("--schedule=count",),
    "score": (),
}
each_verb = pytest.mark.parametrize("verb", FAST)


def asked(verb: str, *folders: Path) -> list[object]:
    """The words of a command about scene folders that does little."""
    places = [word for folder in folders for word in (("--scene", folder) if verb == "compare" else (folder,))]
    return [verb, *places, *FAST.get(verb, ("--once",))]


@each_verb
@pytest.mark.parametrize(("spoil", "words"), SCENES.values(), ids=SCENES.keys())
@pytest.mark.parametrize("existing", [False, True], ids=["", "json exists"])
def test_scenes(command, folder: Path, tmp_path: Path, verb: str, spoil: Spoil, words: str, existing: bool):
    spoil(folder)
    target = tmp_path / "out.json"
    if existing:
        target.write_text("precious")
    before = sorted(tmp_path.rglob("*"))
    output = ("--output", tmp_path / "repaired.json") if verb == "recalibrate" else ()
    command(*asked(verb, folder), "--json", target, "--force", *output).refuses(words)
    assert sorted(tmp_path.rglob("*")) == before
    assert not existing or target.read_text() == "precious"


@each_verb
@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_unreadable(command, folder: Path, verb: str):
    (folder / "left.png").chmod(0)
    command(*asked(verb, folder)).refuses("left.png: cannot be read")


@each_verb
def test_one_bad_scene_among_good_ones(command, folder: Path, clean_scene: Path, verb: str):
    (folder / "left.png").unlink()
    command(*asked(verb, clean_scene, folder)).refuses("there is no image left.*")


LOOSE: dict[str, tuple[list[str], str]] = {
    "nothing": ([], "give scene folders, or --left, --right and --calibration together"),
    "both": (["{0}", "--left={0}/left.png", "--right={0}/right.png", "--calibration={0}/calib.json"], "give scene"),
    "left alone": (["--left={0}/left.png"], ": --left needs --right and --calibration; add them."),
    "no right": (
        ["--left={0}/left.png", "--calibration={0}/calib.json"],
        ": --left and --calibration need --right; add it.",
    ),
    "no calibration": (
        ["--left={0}/left.png", "--right={0}/right.png"],
        ": --left and --right need --calibration; add it.",
    ),
    "empty names": (
        ["--left=", "--right=", "--calibration="],
        " is empty; give the name of a file or folder, or a value.",
    ),
    "an empty side": (["--side-by-side=", "--calibration={0}/calib.json"], ": --side-by-side is empty; give the name"),
    "an empty calibration": (
        ["--left={0}/left.png", "--right={0}/right.png", "--calibration="],
        ": --calibration is empty; give the name",
    ),
    "an empty scene": ([""], ": SCENE is empty; give the name"),
    "an empty result": (["{0}", "--json="], ": --json is empty; give the name"),
    "a file for a scene": (["{0}/calib.json"], "calib.json: this is a file; give the folder of the recording."),
    "a pattern without quotes": (
        ["--left={0}/left.png", "{0}/a.png", "{0}/b.png", "--right={0}/right.png", "--calibration={0}/calib.json"],
        "must be quoted",
    ),
    "no topics": (
        ["--bag=x.bag", "--calibration={0}/calib.json"],
        ": --bag and --calibration need --left and --right; add them.",
    ),
    "two kinds": (
        ["--side-by-side={0}/left.png", "--left={0}/left.png", "--right={0}/right.png", "--calibration={0}/calib.json"],
        ": --left and --right, --side-by-side, or --bag: give one of these.",
    ),
    "a scene and a video": (
        ["scene", "--side-by-side={0}/left.png", "--calibration={0}/calib.json"],
        "give scene folders or --side-by-side and --calibration, not both; scene is taken for a scene folder",
    ),
    "calibration alone": (["--calibration={0}/calib.json"], ": --calibration needs images: --left and --right, "),
    "bag alone": (["--bag={0}"], ": --bag needs --left and --right; add them."),
    "two ways": (
        ["--side-by-side={0}/left.png", "--bag={0}", "--calibration={0}/calib.json"],
        ": --left and --right, --side-by-side, or --bag: give one of these.",
    ),
    "no image matches": (
        ["--left={0}/l*.jpg", "--right={0}/right.png", "--calibration={0}/calib.json"],
        "l*.jpg: no image matches",
    ),
    "no such calibration": (
        ["--left={0}/left.png", "--right={0}/right.png", "--calibration={0}/c.json"],
        "c.json: there is no such file",
    ),
    "an image for a calibration": (
        ["--left={0}/left.png", "--right={0}/right.png", "--calibration={0}/left.png"],
        "left.png: not a text file",
    ),
    "one image twice": (
        ["--left={0}/left.png", "--right={0}/left.png", "--calibration={0}/calib.json"],
        "both the left and the right image",
    ),
}


@pytest.mark.parametrize(("words", "said"), LOOSE.values(), ids=LOOSE.keys())
@pytest.mark.parametrize("verb", ["recalibrate", "score"])
def test_files_that_lie_anywhere(command, clean_scene: Path, verb: str, words: list[str], said: str):
    command(verb, *(word.format(clean_scene) for word in words)).refuses(said)


COMMON: dict[str, tuple[list[str], str]] = {
    "matcher": (["--matcher", "sgmb"], "unknown matcher 'sgmb'; did you mean sgbm?"),
    "unknown option": (["--colour", "red"], "--colour"),
}
SEARCH: dict[str, tuple[list[str], str]] = {
    "schedule": (["--schedule", "coarse"], "unknown --schedule 'coarse' (choose one of: default, count)"),
    "executor": (["--executor", "thread:2"], "unknown executor"),
    "workers": (["--executor", "threads:0"], "--executor is 'threads:0'"),
    "no workers": (["--executor", "processes"], "give the number of workers"),
    "reach zero": (["--reach", "0,0.03"], "a reach of 0.0 degrees"),
    "reach huge": (["--reach", "90,0.03"], "a reach of 90.0 degrees"),
    "reach NaN": (["--reach", "nan,0.03"], "a reach of nan degrees"),
    "reach of one number": (["--reach", "3"], "--reach is '3'; give degrees and a fraction"),
    "reach empty": (["--reach", ""], "--reach"),
    "seed": (["--seed", "-1"], "--seed is -1"),
    "seed word": (["--seed", "x"], "--seed"),
}
COMPARE: dict[str, tuple[list[str], str]] = {
    "budget zero": (["--budget", "0"], "the budget of 0.0 evaluations makes no sense"),
    "budget negative": (["--budget", "-5"], "the budget of -5.0 evaluations makes no sense"),
    "budget NaN": (["--budget", "nan"], "the budget of nan evaluations makes no sense"),
    "budget word": (["--budget", "much"], "--budget"),
    "scale zero": (["--scale", "0"], "scale"),
    "scale above one": (["--scale", "1.5"], "scale"),
    "scale NaN": (["--scale", "nan"], "scale"),
    "scale too small": (["--scale", "0.05"], "at least 16 pixels"),
    "frames": (["--frames", "0"], "--frames is '0'"),
    "frames word": (["--frames", "few"], "--frames is 'few'"),
    "strategy": (["--strategies", "compas"], "unknown strategy 'compas'; did you mean compass?"),
    "one of two strategies": (["--strategies", "compass,nonsense"], "unknown strategy 'nonsense'"),
    "no strategy": (["--strategies", ","], "strateg"),
    "kind of scene": (["--synthetic", "harbor"], "unknown --synthetic 'harbor' (did you mean harbour?)"),
    "drift negative": (["--decalibrate", "-1,0.01"], "a drift of -1.0 degrees"),
    "drift huge": (["--decalibrate", "0.5,2"], "a drift of 0.5 degrees and 2.0 of the baseline"),
    "drift word": (["--decalibrate", "a,b"], "--decalibrate is 'a,b'"),
    "free": (["--free", "left.k"], "unknown parameter 'left.k'; did you mean left.k"),
    "no draws": (["--draws", "0"], "at least one scene, one strategy and one draw"),
    "draws word": (["--draws", "two"], "--draws"),
}
RECORDED: dict[str, tuple[list[str], str]] = {
    "pairs": (["--pairs", "few"], "--pairs is 'few'"),
    "pairs behind the end": (["--pairs", "5:"], "of 1 pairs, --pairs 5: leaves none"),
    "pairs in no steps": (["--pairs", "::0"], "--pairs ::0 selects nothing"),
    "pairs backwards": (["--pairs", "2:1"], "--pairs 2:1 selects nothing"),
    "pairs from the end": (["--pairs", "-1"], "--pairs"),
    "limit": (["--limit", "few"], "--limit is 'few'; give a positive number or all."),
    "tolerance in a folder": (["--tolerance", "0.01"], ": --tolerance belongs to --left and --right, or --bag; "),
    "unit of a folder": (["--unit", "mm"], "belong to --calibration"),
    "field too wide": (["--view", "field=200"], "the field of a view is 200.0; give degrees, more than 0 and at most"),
    "field of a pinhole": (["--view", "projection=pinhole,field=170"], "at most 165 of pinhole"),
    "field NaN": (["--view", "field=nan"], "the field of a view is nan"),
    "field too narrow": (["--view", "field=0.001"], "a field of 0.001 degrees magnifies the images"),
    "field word": (["--view", "field=wide"], "--view has 'field=wide'; give degrees, such as field=140"),
    "projection": (["--view", "projection=fisheye"], "there is no projection 'fisheye'; give one of pinhole, equi"),
    "view without a name": (["--view", "pinhole"], "unknown argument of --view 'pinhole'; choose one of: projection,"),
    "view with another": (["--view", "fields=80"], "did you mean field?"),
    "view empty": (["--view", ""], "--view is empty; give"),
    "tolerances": (["--tolerances", "harm"], "give NAME=NUMBER"),
    "tolerances of another name": (["--tolerances", "hram=0.1"], "did you mean harm"),
    "tolerances beyond": (["--tolerances", "harm=2"], "between 0 and 1"),
    "distances": (["--distances", "near"], "give baselines"),
    "distances zero": (["--distances", "0"], "in baselines, each 1 or more"),
}
PRIOR: dict[str, tuple[list[str], str]] = {
    "prior": (["--prior", "sure"], "unknown prior 'sure'; choose one of: saved, default, exact"),
    "prior that is not there": (["--prior", "saved"], "no prior is saved with this calibration"),
}
RECALIBRATE: dict[str, tuple[list[str], str]] = {
    "strategy": (["--strategy", "compas"], "unknown strategy 'compas'; did you mean compass?"),
    "free": (["--free", "extrinsic"], "did you mean extrinsics"),
    "free alone": (["--free", "intrinsics"], "a schedule that ends on the count estimates neither intrinsics nor"),
    "free empty": (["--free", ""], "--free is empty; give"),
    "ranges": (["--ranges", "/none.csv"], "no such file"),
    "need not met": (["--strategy", "optimistix-levenberg-marquardt"], "needs"),
    "output in no folder": (["--output", "/nowhere/at/all/calib.json"], "--output /nowhere/at/all/calib.json: cannot"),
}
OPTIONS = {
    f"{verb}, {name}": (verb, *case)
    for verb, cases in {
        "compare": COMMON | SEARCH | COMPARE,
        "recalibrate": COMMON | RECORDED | PRIOR | SEARCH | RECALIBRATE,
        "score": COMMON | RECORDED | PRIOR,
        "monitor": COMMON | RECORDED,
    }.items()
    for name, case in cases.items()
}


@pytest.mark.parametrize(("verb", "words", "said"), OPTIONS.values(), ids=OPTIONS.keys())
def test_options(command, clean_scene: Path, tmp_path: Path, verb: str, words: list[str], said: str):
    target = tmp_path / "out.json"
    target.write_text("precious")
    scene = [] if "--synthetic" in words else [clean_scene]
    # An option whose value starts with "-" needs "=".
    joined = [f"{option}={value}" for option, value in zip(words[::2], words[1::2], strict=True)]
    command(*asked(verb, *scene), f"--json={target}", "--force", *joined).refuses(said)
    assert target.read_text() == "precious"


@each_verb
@pytest.mark.parametrize("name", ["nowhere/out.json", ""])
def test_places_that_cannot_be_written(command, clean_scene: Path, tmp_path: Path, verb: str, name: str):
    command(*asked(verb, clean_scene), "--json", tmp_path / name).refuses("cannot be written there")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", [[], ["comapre"], ["strategies", "check"], ["strategies", "check", "compas"]])
def test_commands(command, words: list[str]):
    command(*words).refuses("compass" if len(words) == 3 else "")


@pytest.mark.parametrize(
    "words",
    ["compare --scene {}", "compare --scene {} --strategies all", "recalibrate {}", "recalibrate {} --schedule count"],
)
def test_missing_compass_gives_the_install_line(command, clean_scene: Path, nothing_installed, words: str):
    command(*words.format(clean_scene).split()).refuses("pip install 'stereorecal[default]'")


@pytest.mark.parametrize("option", ["--pairs {}", "--limit {}", "--executor threads:{}", "--executor processes:{}"])
def test_numbers_without_end(command, clean_scene: Path, option: str):
    """Python itself refuses to read more than 4 300 digits."""
    answer = command("recalibrate", clean_scene, *option.format("9" * 5000).split())
    answer.refuses()
    assert len(answer.err) < 200
