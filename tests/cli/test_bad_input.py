"""Bad input: exit code 2, one sentence on stderr that says the thing, nothing written, nothing overwritten.

What is wrong with files is told by tests/io; here, that it reaches the user, and what commands refuse themselves.
"""

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

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


def no_image(folder: Path) -> None:
    (folder / "right.png").unlink()


def truncated(folder: Path) -> None:
    (folder / "right.png").write_bytes((folder / "right.png").read_bytes()[:1000])


def swapped(folder: Path) -> None:
    left, right = ((folder / f"{side}.png").read_bytes() for side in ("left", "right"))
    (folder / "left.png").write_bytes(right)
    (folder / "right.png").write_bytes(left)


def no_calibration(folder: Path) -> None:
    path = folder / "calib.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | dict.fromkeys(("K_left", "K_right", "R", "T"))))


@pytest.mark.parametrize(
    ("verb", "spoil", "said", "existing"),
    [
        ("recalibrate", no_image, "there is no image right.*", True),
        ("recalibrate", truncated, "right.png: the image is truncated", False),
        *((verb, swapped, "look exchanged", True) for verb in FAST),
        *((verb, no_calibration, "the scene has no calibration", False) for verb in FAST),
    ],
)
def test_scenes(
    command, folder: Path, tmp_path: Path, verb: str, spoil: Callable[[Path], None], said: str, existing: bool
):
    spoil(folder)
    target = tmp_path / "out.json"
    if existing:
        target.write_text("precious")
    before = sorted(tmp_path.rglob("*"))
    output = ("--output", tmp_path / "repaired.json") if verb == "recalibrate" else ()
    command(*asked(verb, folder), "--json", target, "--force", *output).refuses(said)
    assert sorted(tmp_path.rglob("*")) == before
    assert not existing or target.read_text() == "precious"


@each_verb
@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_unreadable(command, folder: Path, verb: str):
    (folder / "left.png").chmod(0)
    command(*asked(verb, folder)).refuses("left.png: cannot be read")


@each_verb
def test_one_bad_scene_among_good_ones(command, folder: Path, clean_scene: Path, verb: str):
    no_image(folder)
    command(*asked(verb, clean_scene, folder)).refuses("there is no image right.*")


LEFT, RIGHT, CALIBRATION = "--left={0}/left.png", "--right={0}/right.png", "--calibration={0}/calib.json"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "give scene folders, or --left, --right and --calibration together"),
        (["{0}", LEFT, RIGHT, CALIBRATION], "give scene"),
        ([LEFT], ": --left needs --right and --calibration; add them."),
        ([LEFT, CALIBRATION], ": --left and --calibration need --right; add it."),
        ([LEFT, RIGHT], ": --left and --right need --calibration; add it."),
        ([CALIBRATION], ": --calibration needs images: --left and --right, "),
        ([LEFT, RIGHT, "--calibration="], ": --calibration is empty; give the name of a file or folder, or a value."),
        ([""], ": SCENE is empty; give the name"),
        (["{0}/calib.json"], "calib.json: this is a file; give the folder of the recording."),
        ([LEFT, "{0}/a.png", "{0}/b.png", RIGHT, CALIBRATION], "must be quoted"),
        (["--bag=x.bag", CALIBRATION], ": --bag and --calibration need --left and --right; add them."),
        (["--bag={0}"], ": --bag needs --left and --right; add them."),
        (
            ["--side-by-side={0}/left.png", LEFT, RIGHT, CALIBRATION],
            ": --left and --right, --side-by-side, or --bag: give one of these.",
        ),
        (
            ["scene", "--side-by-side={0}/left.png", CALIBRATION],
            "give scene folders or --side-by-side and --calibration, not both; scene is taken for a scene folder",
        ),
        ([LEFT, RIGHT, "--calibration={0}/c.json"], "c.json: there is no such file"),
        ([LEFT, "--right={0}/left.png", CALIBRATION], "both the left and the right image"),
    ],
)
def test_files_that_lie_anywhere(command, clean_scene: Path, words: list[str], said: str):
    command("score", *(word.format(clean_scene) for word in words)).refuses(said)


OPTIONS = {
    "compare": {
        "--schedule=coarse": "unknown --schedule 'coarse' (choose one of: default, count)",
        "--reach=3": "--reach is '3'; give degrees and a fraction",
        "--budget=0": "the budget of 0.0 evaluations makes no sense",
        "--scale=0": "scale",
        "--scale=0.05": "at least 16 pixels",
        "--frames=0": "--frames is '0'",
        "--strategies=compass,compas": "unknown strategy 'compas'; did you mean compass?",
        "--strategies=,": "strateg",
        "--synthetic=harbor": "unknown --synthetic 'harbor' (did you mean harbour?)",
        "--decalibrate=-1,0.01": "a drift of -1.0 degrees",
        "--decalibrate=a,b": "--decalibrate is 'a,b'",
        "--free=left.k": "unknown parameter 'left.k'; did you mean left.k",
        "--seed=-1": "--seed is -1",
        "--draws=0": "at least one scene, one strategy and one draw",
    },
    "recalibrate": {
        "--matcher=sgmb": "unknown matcher 'sgmb'; did you mean sgbm?",
        "--pairs=few": "--pairs is 'few'",
        "--limit=few": "--limit is 'few'; give a positive number or all.",
        "--pairs=::0": "--pairs ::0 selects nothing",
        "--pairs=2:1": "--pairs 2:1 selects nothing",
        "--pairs=-1": "--pairs",
        "--tolerance=0.01": ": --tolerance belongs to --left and --right, or --bag; ",
        "--unit=mm": "belong to --calibration",
        "--view=field=200": "the field of a view is 200.0; give degrees, more than 0 and at most",
        "--view=field=0.001": "a field of 0.001 degrees magnifies the images",
        "--view=field=wide": "--view has 'field=wide'; give degrees, such as field=140",
        "--view=projection=fisheye": "unknown projection 'fisheye'; choose one of: pinhole, equi",
        "--view=pinhole": "unknown argument of --view 'pinhole'; choose one of: projection,",
        "--view=fields=80": "did you mean field?",
        "--view=": "--view is empty; give",
        "--tolerances=harm": "give NAME=NUMBER",
        "--tolerances=hram=0.1": "did you mean harm",
        "--distances=near": "give lengths",
        "--tolerances=distances=0": "in baselines, each 1 or more",
        "--tolerances=harm=1:2": "give NAME=NUMBER",
        "--tolerances=harm=0.5, harm=0.01": "--tolerances has 'harm' twice; give it once.",
        "--view=projection=pinhole,projection=fisheye": "--view has 'projection' twice; give it once.",
        "--prior=sure": "unknown prior 'sure'; choose one of: saved, default, exact",
        "--prior=saved": "no prior is saved with this calibration",
        "--executor=thread:2": "unknown executor",
        "--executor=serial:4": "unknown executor 'serial'",
        "--executor=threads:0": "--executor is 'threads:0'",
        "--executor=processes": "give the number of workers",
        "--free=" + 20 * "left.k1,": "give names of parameters",
        "--reach=0,0.03": "a reach of 0.0 degrees",
        "--schedule=count:compas": "unknown strategy 'compas'; did you mean compass?",
        "--schedule=count:": "unknown strategy ''; installed: ",
        "--schedule=count:optimistix-levenberg-marquardt": "needs",
        "--free=extrinsic": "did you mean extrinsics",
        "--free=intrinsics": "a schedule that ends on the count estimates neither intrinsics nor",
        "--ranges=/none.csv": "no such file",
        "--output=/nowhere/at/all/calib.json": "--output /nowhere/at/all/calib.json: cannot",
    },
    "score": {"--pairs=5:": "of 1 pairs, --pairs 5: leaves none"},
    "monitor": {"--pairs=5:": "of 1 pairs, --pairs 5: leaves none"},
}


@pytest.mark.parametrize(
    ("verb", "option", "said"),
    [(verb, option, said) for verb, options in OPTIONS.items() for option, said in options.items()],
)
def test_options(command, clean_scene: Path, tmp_path: Path, verb: str, option: str, said: str):
    target = tmp_path / "out.json"
    target.write_text("precious")
    scene = [] if option.startswith("--synthetic") else [clean_scene]
    command(*asked(verb, *scene), f"--json={target}", "--force", option).refuses(said)
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


@pytest.mark.parametrize("option", ["--pairs={}", "--limit={}", "--executor=threads:{}", "--executor=processes:{}"])
def test_numbers_without_end(command, clean_scene: Path, option: str):
    """Python itself refuses to read more than 4 300 digits."""
    answer = command("recalibrate", clean_scene, option.format("9" * 5000))
    answer.refuses()
    assert len(answer.err) < 200
