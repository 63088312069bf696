"""Scenes large enough for counts to mean something; how often JAX traces and compiles."""

from collections.abc import Callable, Iterator

import jax
import numpy as np
import pytest

import stereorecal as sr
from stereorecal.geometry import with_unit_baseline
from stereorecal.recordings import Scene

_EVENTS = {
    "/jax/core/compile/jaxpr_trace_duration": "traced",
    "/jax/core/compile/backend_compile_duration": "compiled",
}


@pytest.fixture(scope="session")
def scene(scene: Callable[..., Scene]) -> Callable[..., Scene]:
    """As the scene that all tests share, but 320x240 unless a size is given."""

    def make(kind: str = "harbour", seed: int = 0, size: tuple[int, int] = (320, 240), frames: int = 1) -> Scene:
        return scene(kind, seed, size, frames)

    return make


@pytest.fixture(scope="session")
def small(scene) -> Scene:
    """160x120, and what the pure face needs of it: `data`, and `truth`, the extrinsics in baselines."""
    return scene(size=(160, 120))


@pytest.fixture(scope="session")
def data(small) -> sr.ScoringData:
    return sr.prepare(small.rig, small.pairs)


@pytest.fixture(scope="session")
def truth(small) -> np.ndarray:
    return with_unit_baseline(small.rig.extrinsics)


@pytest.fixture
def compilations() -> Iterator[list[str]]:
    """A list that grows by "traced" and "compiled", until the test is over."""
    seen: list[str] = []

    def heard(name: str, seconds: float, **_: object) -> None:
        if name in _EVENTS:
            seen.append(_EVENTS[name])

    if not hasattr(jax.monitoring, "unregister_event_duration_listener"):
        pytest.skip("this JAX never lets a listener go")
    jax.monitoring.register_event_duration_secs_listener(heard)
    yield seen
    jax.monitoring.unregister_event_duration_listener(heard)
