"""Benchmarks are run by hand: what they take from the library, and from each other, is held to be there."""

import ast
import importlib.util
from collections.abc import Iterator
from pathlib import Path

import pytest

import stereorecal as sr

FOLDER = Path(__file__).parent / "benchmarks"
SCRIPTS = sorted(FOLDER.glob("*.py"))
OURS = ("stereorecal", *(path.parent.name for path in FOLDER.parents[1].glob("plugins/*/stereorecal_*/__init__.py")))


def taken(code: str) -> Iterator[tuple[str, str]]:
    """Module and name of everything that is imported from somewhere, or read off `sr`."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "sr":
            yield "stereorecal", node.attr


def made(script: Path) -> set[str]:
    """The names that a script defines."""
    body = ast.parse(script.read_text()).body
    assigned = (target for node in body if isinstance(node, ast.Assign) for target in node.targets)
    return {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)} | {
        name.id for target in assigned for name in ast.walk(target) if isinstance(name, ast.Name)
    }


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_what_it_needs_is_there(script: Path):
    siblings = {path.stem: path for path in SCRIPTS}
    for module, name in taken(script.read_text()):
        if module in siblings:
            assert name in made(siblings[module]), f"{module} has no {name}"
        elif module.partition(".")[0] in OURS:
            found = importlib.import_module(module)
            assert hasattr(found, name) or importlib.util.find_spec(f"{module}.{name}"), f"{module} has no {name}"


def test_what_is_not_there_is_seen(tmp_path: Path):
    script = tmp_path / "bench.py"
    script.write_text("from stereorecal.recalibration._stages import nobody\nsr.nothing\n")
    assert list(taken(script.read_text())) == [
        ("stereorecal.recalibration._stages", "nobody"),
        ("stereorecal", "nothing"),
    ]
    assert not hasattr(sr, "nothing")
