"""Robots that keep their state in a folder of the test's."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from robots import Robot


@pytest.fixture
def robot(tmp_path: Path) -> Callable[..., Robot]:
    return partial(Robot, tmp_path)
