"""Scenes large enough for counts to mean something."""

from collections.abc import Callable

import pytest

from stereorecal.recordings import Scene


@pytest.fixture(scope="session")
def scene(scene: Callable[..., Scene]) -> Callable[..., Scene]:
    """As the scene that all tests share, but 320x240 unless a size is given."""

    def make(kind: str = "harbour", seed: int = 0, size: tuple[int, int] = (320, 240), frames: int = 1) -> Scene:
        return scene(kind, seed, size, frames)

    return make
