"""What all tests share."""

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

import jax
import pytest
from hypothesis import settings

from stereorecal.recordings import Scene
from stereorecal.synthetic import default_rig, render

os.environ["JAX_ENABLE_COMPILATION_CACHE"] = "false"  # of commands that tests start: nothing of the user's is touched
jax.config.update("jax_enable_compilation_cache", False)

settings.register_profile("stereorecal", derandomize=True, deadline=None)
settings.load_profile("stereorecal")


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real scenes that the environment variable STEREORECAL_DATA names; skips without it."""
    name = os.environ.get("STEREORECAL_DATA")
    if not name:
        pytest.skip("set STEREORECAL_DATA to the folder of real scenes to run this test")
    if not Path(name).is_dir():
        pytest.skip(f"STEREORECAL_DATA={name} is no folder")
    return Path(name)


@pytest.fixture(scope="session")
def scene() -> Callable[..., Scene]:
    """scene(kind, seed, size, frames): a rendered scene, made once; 160x120 unless a size is given."""

    @cache
    def make(kind: str = "harbour", seed: int = 0, size: tuple[int, int] = (160, 120), frames: int = 1) -> Scene:
        return render(kind, seed, rig=default_rig().resized(size), frames=frames)

    return make
