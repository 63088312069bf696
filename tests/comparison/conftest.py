"""Strategies that worker processes can import."""

import importlib
import sys
from collections.abc import Callable, Iterator
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
