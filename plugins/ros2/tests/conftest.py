"""Robots that keep their state in a folder of the test's."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from robots import Robot


@pytest.fixture
def blank(tmp_path: Path) -> Callable[..., Robot]:
    """blank(settings...): one whose cameras have told nothing yet."""
    return partial(Robot, tmp_path)


@pytest.fixture
def robot(blank: Callable[..., Robot]) -> Callable[..., Robot]:
    """robot(settings...): one whose cameras are calibrated, and that has seen a pair."""

    def begun(**settings: Any) -> Robot:
        one = blank(**settings)
        one.calibrate()
        one.see()
        return one

    return begun
