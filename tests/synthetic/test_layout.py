"""Where things are in synthetic: a scene kind is a module of scenes/, and imports run one way."""

import ast
from collections import Counter
from pathlib import Path

import pytest

import stereorecal.synthetic as synthetic
from stereorecal.synthetic import KINDS
from stereorecal.synthetic.scenes import MAKERS

ROOT = Path(synthetic.__file__).parent
# Each may import itself and those before it; modules at the top may import all of them.
ORDER = ("rendering", "surroundings", "objects", "world", "scenes")


def test_every_module_of_scenes_is_a_kind_and_is_registered():
    modules = {path.stem for path in (ROOT / "scenes").glob("*.py")} - {"__init__"}
    makers = Counter(maker.__module__.rpartition(".")[2] for maker in MAKERS.values())
    assert makers == Counter(modules)
    assert {f"_{kind.replace('-', '_')}" for kind in KINDS} == modules


def test_kinds_keep_their_positions():
    """The position is part of the seed: another order would change every image of a kind."""
    assert KINDS[:4] == ("harbour", "coast", "open-sea", "street")


def test_every_folder_has_its_place():
    assert {path.parent.name for path in ROOT.glob("*/__init__.py")} == set(ORDER)


@pytest.mark.parametrize("folder", ORDER)
def test_imports_run_one_way(folder: str):
    allowed = ORDER[: ORDER.index(folder) + 1]
    found = set()
    for path in (ROOT / folder).glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom):
                module = (node.module or "").split(".")
                assert node.level == 0, f"{path}: import by the full name"
                if module[:2] == ["stereorecal", "synthetic"]:
                    found.add(module[2] if len(module) > 2 else "synthetic itself")
    assert found <= set(allowed), f"{folder} must not import {found - set(allowed)}"
