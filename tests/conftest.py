"""What all tests share."""

import os
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path

import jax
import pytest
import typechecking
from hypothesis import settings

from stereorecal.recordings import Scene
from stereorecal.synthetic import default_rig, render

_CACHE = "STEREORECAL_TEST_CACHE"
_COMPILED_FAST = (
    "--xla_backend_optimization_level=1 --xla_cpu_use_fusion_emitters=false --xla_cpu_parallel_codegen_split_count=1"
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """What is not asked for by its file is run without what is slow."""
    parser.addoption("--slow", action="store_true", help="also what is marked slow: the second proofs")


def pytest_configure(config: pytest.Config) -> None:
    """One compilation cache for all workers of a run and the commands that they start, in a folder of the run's own (or
    the one that STEREORECAL_TEST_CACHE names, for those who run tests again and again): nothing of the user's is
    touched, and what one worker has compiled the others read."""
    if _is_worker(config):
        folder = os.environ[_CACHE]
    else:
        folder = os.environ.get(_CACHE) or tempfile.mkdtemp(prefix="stereorecal-tests-")
        if _CACHE not in os.environ:
            config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
        os.environ[_CACHE] = os.environ["JAX_COMPILATION_CACHE_DIR"] = folder
        os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0.1"
    config.option.slow |= config.args_source is not pytest.Config.ArgsSource.TESTPATHS and not _is_worker(config)
    if not config.option.slow:
        # Half of the quick suite's time went by in XLA. With --slow, programs are those that users have.
        os.environ.setdefault("XLA_FLAGS", _COMPILED_FAST)
    if not _is_worker(config):
        # Each core has a worker of its own: threads of BLAS would only wait for each other.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    config.pluginmanager.register(typechecking)  # whose tests may lie outside this folder
    jax.config.update("jax_compilation_cache_dir", folder)
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)


_FIRST = (
    "test_architecture",
    "test_compiled_once",
    "test_default_schedule",
    "test_nlopt_conformance",
    "test_tutorial_plugins",
)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Long files first, so that no worker is left alone with one; and those that compile what many others use.

    Without --slow, tests of the mark `slow` are left out; of `slow(after=n)` all but the first n cases.
    """
    items.sort(key=lambda item: item.path.stem not in _FIRST)
    if config.option.slow:
        return
    cases: Counter[str] = Counter()
    left_out = []
    for item in items:
        if mark := item.get_closest_marker("slow"):
            name = item.nodeid.partition("[")[0]
            cases[name] += 1
            if cases[name] > mark.kwargs.get("after", 0):
                left_out.append(item)
    config.hook.pytest_deselected(items=left_out)
    kept = set(items) - set(left_out)
    items[:] = [item for item in items if item in kept]


def _is_worker(config: pytest.Config) -> bool:
    return hasattr(config, "workerinput")


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
