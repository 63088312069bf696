"""Real scenes, which lie outside of the project."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real scenes that the environment variable STEREORECAL_DATA names; skips without it."""
    name = os.environ.get("STEREORECAL_DATA")
    if not name:
        pytest.skip("set STEREORECAL_DATA to the folder of real scenes to run this test")
    if not Path(name).is_dir():
        pytest.skip(f"STEREORECAL_DATA={name} is no folder")
    return Path(name)
