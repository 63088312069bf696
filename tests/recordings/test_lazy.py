"""A recording may be longer than the memory: pairs are read when they are needed, and let go."""

import json
import os
import pickle
import weakref
from pathlib import Path

import numpy as np
import pytest
from parts_of_repairs import _load_pairs

from stereorecal import InputError
from stereorecal.cli import main
from stereorecal.io import files_read, load_log, load_scene, open_pairs, save_scene
from stereorecal.recalibration import chosen_frames
from stereorecal.recordings import Pair, names_of, times_of
from stereorecal.synthetic import default_rig, render

FRAMES = 120


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene folder of many frames, all links to the images of one."""
    made = tmp_path_factory.mktemp("long") / "scene"
    save_scene(render("harbour", 0, rig=default_rig().resized((64, 48))), made)
    for side in ("left", "right"):
        first = made / side / "0000.png"
        first.parent.mkdir()
        (made / f"{side}.png").rename(first)
        for number in range(1, FRAMES):
            os.link(first, made / side / f"{number:04d}.png")
    return made


class Meter:
    """How many pairs were read, and the most that were there at once."""

    def __init__(self):
        self.read = self.most = 0
        self.alive: weakref.WeakSet[Pair] = weakref.WeakSet()

    def __call__(self, *file, load=_load_pairs.read_pair) -> Pair:
        pair = load(*file)
        self.alive.add(pair)
        self.read += 1
        self.most = max(self.most, len(self.alive))
        return pair


@pytest.fixture
def meter(monkeypatch: pytest.MonkeyPatch) -> Meter:
    found = Meter()
    monkeypatch.setattr(_load_pairs, "read_pair", found)
    return found


def test_a_log_is_opened_without_reading_it(folder: Path, meter: Meter):
    log = load_log(folder)
    (mission,) = log.missions
    assert names_of(mission.pairs) == tuple(f"{number:04d}.png" for number in range(FRAMES))
    assert times_of(mission.pairs) == (None,) * FRAMES
    assert len(mission.pairs[1:6:2]) == 3
    assert meter.read == 1
    for _ in mission.pairs:
        pass
    assert meter.read == FRAMES + 1
    assert meter.most <= 2


def test_of_a_scene_only_what_is_chosen_stays(folder: Path, meter: Meter):
    assert len(load_scene(folder, choose=lambda pairs: chosen_frames(pairs, 5)).pairs) == 5
    assert meter.most <= 5 + 2


@pytest.mark.slow
def test_a_command_looks_at_some_of_a_long_recording(folder: Path, meter: Meter, capsys):
    """Not where all were asked for."""
    quickly = ("--schedule", "count", "--matcher", "bm", "--json", "-")

    def frames(*words: str) -> int:
        main(["recalibrate", str(folder), *quickly, *words])
        return json.loads(capsys.readouterr().out)["repairs"][0]["frames"]

    assert frames() == 24
    assert meter.most <= 24 + 2
    assert frames("--pairs", ":100") == 24
    assert frames("--limit", "all") == FRAMES


def test_pairs_travel_as_paths(folder: Path):
    log = load_log(folder)
    some = log.missions[0].pairs[3:5]
    sent = pickle.dumps(some)
    assert len(sent) < 10_000
    again = pickle.loads(sent)
    np.testing.assert_array_equal(again[1].left, some[1].left)
    assert names_of(again) == ("0003.png", "0004.png")
    loose = open_pairs(folder / "left", folder / "right").pairs[:2]
    assert len(pickle.dumps(loose)) < 10_000


def test_all_files_of_a_log_are_inputs(folder: Path):
    """Read or not: none may be replaced."""
    with files_read() as read:
        load_log(folder, limit=1)
    assert {folder / "left" / "0119.png", folder / "right" / "0090.png", folder / "calib.json"} <= read


def test_what_is_wrong_with_a_pair_is_said_when_it_is_read(folder: Path, tmp_path: Path):
    made = tmp_path / "scene"
    save_scene(load_scene(folder, limit=2), made)
    path = made / "left" / "0001.png"
    path.write_bytes(path.read_bytes()[:100])
    log = load_log(made)
    with pytest.raises(InputError, match="the image is truncated"):
        log.scene(log.missions[0])
