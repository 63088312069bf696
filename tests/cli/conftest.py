"""Plug-ins that crash, and small scene folders to spoil."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fixtures import at_once as at_once, clean_scene as clean_scene, command as command
from moody import MoodyMatcher
from rides import Ride, ride_of
from spoiled import turned

from stereorecal.io import save_scene
from stereorecal.recordings import Scene


@pytest.fixture
def crashing(nothing_installed, install) -> None:
    """A strategy "crashing" beside compass, and no other."""
    install("stereorecal.strategies", {"compass": "stereorecal_compass:Compass", "crashing": "moody:Crashing"})


@pytest.fixture
def moody_matcher(install) -> Callable[..., list[tuple[int, int]]]:
    """moody_matcher(mood): what the installed matcher "moody" does from now on, told the number of its search; and the
    shapes of the images of its searches."""
    install("stereorecal.matchers", {"moody": "moody:MoodyMatcher"})

    def set_up(mood: Callable[[int], None] = lambda search: None) -> list[tuple[int, int]]:
        MoodyMatcher.searches.clear()
        MoodyMatcher.mood = mood
        return MoodyMatcher.searches

    return set_up


@pytest.fixture(scope="session")
def drifted_scene(scene: Callable[..., Scene], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same pair with a rig that drifted by almost a degree, and a key of the user's own; not to be changed."""
    folder, shown = tmp_path_factory.mktemp("scenes") / "drifted", scene()
    rig = turned(shown.rig, 0.8, 0.3, -0.9, 0.003, -0.003)
    save_scene(replace(shown, rig=rig, reference="stored", info={"boat": "Ladja"}), folder)
    return folder


@pytest.fixture
def folder(clean_scene: Path, tmp_path: Path) -> Path:
    """A copy of it, free to be spoiled."""
    return Path(shutil.copytree(clean_scene, tmp_path / "scene"))


@pytest.fixture
def unworked(moody) -> tuple[str, ...]:
    """The options of a repair by a strategy that fails if it has work: whatever is refused is refused before."""
    moody(lambda run: pytest.fail("worked before it looked"))
    return "--schedule", "count:moody"


@pytest.fixture(scope="session")
def drive(once: Callable[..., Any]) -> Ride:
    """A recording with a knock of 0.3 degrees of pitch, and eight pairs after it."""
    return once("drive", lambda: ride_of(0.3, 8))
