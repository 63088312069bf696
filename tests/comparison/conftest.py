"""Rendered scenes, each made once."""

from collections.abc import Callable
from functools import cache

import pytest

from stereorecal.geometry import Scene
from stereorecal.synthetic import default_rig, render

TINY = (160, 120)


@pytest.fixture(scope="session")
def scene() -> Callable[..., Scene]:
    """scene(kind, seed, size): a rendered scene; 160x120 unless a size is given."""

    @cache
    def make(kind: str = "harbour", seed: int = 0, size: tuple[int, int] = TINY, frames: int = 1) -> Scene:
        return render(kind, seed, rig=default_rig().resized(size), frames=frames)

    return make
