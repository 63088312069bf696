"""Pools of a user's own, and strategies that worker processes can import."""

import importlib
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from types import ModuleType

import pytest


@pytest.fixture(scope="module")
def planted(tmp_path_factory) -> Iterator[Callable[[str, str], ModuleType]]:
    """planted(name, code): a module of this code, on the path of workers too."""
    folder, names = tmp_path_factory.mktemp("modules"), []

    def plant(name: str, code: str) -> ModuleType:
        (folder / f"{name}.py").write_text(code)
        names.append(name)
        return importlib.import_module(name)

    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        yield plant
    for name in names:
        del sys.modules[name]


@pytest.fixture(scope="module", params=["threads", "processes"])
def pool(request, planted) -> Iterator[Executor]:
    """With one worker, which finds what is planted."""
    processes = request.param == "processes"
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) if processes else ThreadPoolExecutor(1) as made:
        yield made
