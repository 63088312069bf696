"""What all tests share."""

import gc
import importlib.metadata
import os
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from importlib.metadata import EntryPoints
from pathlib import Path

import jaxlib.version
import pytest

_CACHE = "STEREORECAL_TEST_CACHE"
_COMPILED_FAST = ["--xla_backend_optimization_level=1", "--xla_cpu_parallel_codegen_split_count=1"]
if jaxlib.version.__version_info__ < (0, 11):  # XLA ends a process that names a flag which it no longer has
    _COMPILED_FAST.append("--xla_cpu_use_fusion_emitters=false")


def pytest_addoption(parser: pytest.Parser) -> None:
    """What is not asked for by its file is run without what is slow."""
    parser.addoption("--slow", action="store_true", help="also what is marked slow: the second proofs")


def pytest_configure(config: pytest.Config) -> None:
    """One compilation cache for all workers of a run and the commands that they start, in a folder of the run's own (or
    the one that STEREORECAL_TEST_CACHE names, for those who run tests again and again): nothing of the user's is
    touched, and what one worker has compiled the others read."""
    gc.set_threshold(100_000, 50, 100)  # imports and tracing allocate much and leave little garbage
    if _is_worker(config):
        _keep_to_own_cores(config)
        config.option.slow = config.workerinput["slow"]
    else:
        config.option.slow |= config.args_source is not pytest.Config.ArgsSource.TESTPATHS
        folder = os.environ.get(_CACHE) or tempfile.mkdtemp(prefix="stereorecal-tests-")
        if _CACHE not in os.environ:
            config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
        os.environ[_CACHE] = os.environ["JAX_COMPILATION_CACHE_DIR"] = folder
        os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0.1"
        # Each core has a worker of its own: threads of BLAS would only wait for each other.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if not config.option.slow:
        # Half of the quick suite's time went by in XLA. With --slow, programs are those that users have.
        os.environ.setdefault("XLA_FLAGS", " ".join(_COMPILED_FAST))
    # Commands that tests start read the library as one of them has compiled it.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    if config.option.dist == "no":  # else the workers would wait while this process, too, imports JAX
        gc.disable()  # until all tests are collected: what is imported stays
        config.pluginmanager.import_plugin("running")


def pytest_configure_node(node) -> None:
    """Workers read the command line anew, and not what it came to."""
    node.workerinput["slow"] = node.config.option.slow


def _keep_to_own_cores(config: pytest.Config) -> None:
    """Each worker computes on a share of the cores: threads of several would only wait for each other."""
    if not hasattr(os, "sched_setaffinity"):
        return
    number, workers = int(config.workerinput["workerid"].removeprefix("gw")), config.workerinput["workercount"]
    if own := sorted(os.sched_getaffinity(0))[number::workers]:
        os.sched_setaffinity(0, own)


_FIRST = (
    "test_architecture",
    "test_compiled_once",
    "test_default_schedule",
    "test_nlopt_conformance",
    "test_tutorials",
)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Long files first, documents among them, so that no worker is left alone with one; and those that compile what
    many others use.

    Without --slow, tests of the mark `slow` are left out; of `slow(after=n)` all but the first n cases.
    """
    items.sort(key=lambda item: item.path.suffix != ".md" and item.path.stem not in _FIRST)
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


def pytest_collection_finish(session: pytest.Session) -> None:
    """No look for garbage goes through what was collected here, which stays."""
    gc.collect()
    gc.freeze()
    gc.enable()


def _is_worker(config: pytest.Config) -> bool:
    return hasattr(config, "workerinput")


@pytest.fixture
def nothing_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[dict[str, str]]:
    """No plug-in but those that `install` adds from now on, and what lies in `tmp_path`; and each look at them."""
    before, looks = set(sys.path), []

    def of_others(**wanted: str) -> EntryPoints:
        looks.append(wanted)
        places = [place for place in sys.path if place not in before]
        found = importlib.metadata.distributions(path=places)
        return EntryPoints(point for one in found for point in one.entry_points).select(**wanted)

    monkeypatch.syspath_prepend(tmp_path)  # what was read of the path as it was does not count
    monkeypatch.setattr(importlib.metadata, "entry_points", of_others)
    return looks


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """terminal(stream): this standard stream is a terminal from now on, or is none."""

    def set_up(stream: str, there: bool = True) -> None:
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setattr(getattr(sys, stream), "isatty", lambda: there)

    return set_up
