"""`recalibrate --boards`."""

import json
from pathlib import Path

import pytest
from fixtures import command as command, data_dir as data_dir

import stereorecal as sr

SQUARE = ("--square", "0.03")


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Not to be changed."""
    folder, rig = tmp_path_factory.mktemp("scene"), sr.synthetic.default_rig().resized((160, 120))
    sr.io.save_scene(sr.synthetic.render("harbour", 1, rig=rig), folder)
    return folder


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--boards", "{0}/left.png"), "expected 2 arguments"),
        (("--boards", "{0}/left.png", "{0}/right.png"), "--boards needs --square"),
        (SQUARE, "belong to --boards"),
        (("--board-corners", "9x6"), "belong to --boards"),
        (("--boards", "{0}/left.png", "{0}/right.png", "--square", "-1"), "give metres"),
        (("--boards", "{0}/left.png", "{0}/right.png", "--board-corners", "9", *SQUARE), "such as 9x6"),
        (("--boards", "{0}/left.png", "{0}/right.png", "--prior", "exact", *SQUARE), "give one"),
        (("--boards", "{0}/no.png", "{0}/right.png", *SQUARE), "no such file"),
        (("--boards", "{0}/left.png", "{0}/right.png", *SQUARE), "none of 1 pairs shows a chessboard"),
    ],
)
def test_what_makes_no_sense(command, scene: Path, words, said):
    answer = command("recalibrate", scene, *(word.format(scene) for word in words))
    assert answer.code == 2
    assert said in answer.err
    assert answer.err.count("\n") == 1


@pytest.mark.slow
def test_boards_join_a_repair(command, data_dir: Path, tmp_path: Path):
    rig, target = data_dir / "boofcv_bumblebee2", tmp_path / "solution.json"
    boards = [rig / "calibration_chess" / f"{side}0[1-4].jpg" for side in ("left", "right")]
    words = ("--boards", *boards, "--board-corners", "4x6", *SQUARE, "--json", target)
    answer = command("recalibrate", rig / "garden01", *words)
    assert answer.code in (0, 1)
    content = json.loads(target.read_text())
    assert content["settings"]["prior"] == "given"
    seen = content["repairs"][0]["estimate"]
    low, high = (seen[end][seen["names"].index("left.f")] for end in ("low_95", "high_95"))
    assert high - low < 3.0  # percent; a simulated calibration leaves 3.5
