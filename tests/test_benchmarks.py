"""Benchmarks are run by hand: what they take from the library, and from each other, is held to be there."""

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

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
    assigned = [target for node in body if isinstance(node, ast.Assign) for target in node.targets]
    assigned += [node.target for node in body if isinstance(node, ast.AnnAssign)]
    return {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)} | {
        name.id for target in assigned for name in ast.walk(target) if isinstance(name, ast.Name)
    }


def missing(code: str) -> list[str]:
    """What a script takes and nobody has."""
    siblings = {path.stem: path for path in SCRIPTS}
    absent = []
    for module, name in taken(code):
        if module in siblings:
            there = name in made(siblings[module])
        elif module.partition(".")[0] in OURS:
            found = importlib.import_module(module)
            there = hasattr(found, name) or (Path(found.__file__ or "").parent / f"{name}.py").exists()
        else:
            continue
        absent += [] if there else [f"{module}.{name}"]
    return absent


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_what_it_needs_is_there(script: Path):
    assert missing(script.read_text()) == []


def test_what_is_not_there_is_seen():
    code = "from stereorecal.recalibration._case import Case, nobody\nfrom accuracy import errors, none\nsr.nothing\n"
    assert missing(code) == ["stereorecal.recalibration._case.nobody", "accuracy.none", "stereorecal.nothing"]
