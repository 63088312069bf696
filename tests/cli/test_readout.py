"""`--readout`: what it asks for, and what it refuses."""

import dataclasses
from pathlib import Path

import pytest

from stereorecal import InputError
from stereorecal.cli import options_of
from stereorecal.cli._recordings import recordings
from stereorecal.io import save_scene
from stereorecal.synthetic import default_rig, render


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scene = render("harbour", 0, frames=2, rig=default_rig().resized((64, 48)))
    pairs = tuple(dataclasses.replace(pair, time=0.1 * n).read_out(0.02) for n, pair in enumerate(scene.pairs))
    save_scene(dataclasses.replace(scene, pairs=pairs), made := tmp_path_factory.mktemp("rolling") / "scene")
    return made


def readouts(folder: Path, *words: str, verb: str = "score") -> list[float]:
    (scene,) = recordings(options_of([verb, str(folder), *words])).scenes
    return [pair.readout for pair in scene.pairs]


@pytest.mark.parametrize("verb", ["score", "recalibrate"])
def test_what_is_said_counts_before_what_is_stored(folder, verb):
    assert readouts(folder, verb=verb) == [0.02, 0.02]
    assert readouts(folder, "--readout", "0.03", verb=verb) == [0.03, 0.03]
    assert readouts(folder, "--readout", "0", verb=verb) == [0.0, 0.0]


def test_without_times_it_would_say_nothing(folder, tmp_path: Path):
    scene = render("harbour", 0, rig=default_rig().resized((64, 48)))
    save_scene(scene, tmp_path / "still")
    with pytest.raises(InputError, match="no pair knows its time; leave it out"):
        readouts(tmp_path / "still", "--readout", "0.03")


@pytest.mark.parametrize("seconds", ["-0.01", "2", "nan", "inf"])
def test_what_makes_no_sense_is_refused(folder, seconds):
    with pytest.raises(InputError, match="a rolling shutter"):
        readouts(folder, "--readout", seconds)
