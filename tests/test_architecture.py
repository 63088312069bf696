"""The layers, held by reading the imports; the style, held by the tools."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CORE = ROOT / "stereorecal"
PLUGINS = [path for path in (ROOT / "plugins").glob("*/stereorecal_*") if path.is_dir()]

# Each may import the ones after it; objectives are where strategies, which know no stereo, and scores meet.
CHAIN = (
    "cli",
    "comparison",
    "recalibration",
    "decision",
    "estimation",
    "objectives",
    "scoring",
    "matching",
    "recordings",
)
CHAIN = (*CHAIN, "geometry")
MAY_IMPORT = {name: set(CHAIN[index + 1 :]) for index, name in enumerate(CHAIN)} | {
    "strategies": set(),
    "report": set(),
    "io": {"recordings", "geometry"},
    "synthetic": {"recordings", "geometry"},
}
for above in ("cli", "comparison", "recalibration", "decision", "estimation", "objectives"):
    MAY_IMPORT[above].add("strategies")
MAY_IMPORT["testing"] = MAY_IMPORT["objectives"] | {"objectives", "synthetic"}
MAY_IMPORT["recalibration"] |= {"report", "io"}  # how numbers read, and a page: a solution shows itself
MAY_IMPORT["comparison"] |= {"report", "io", "synthetic"}
MAY_IMPORT["online"] = MAY_IMPORT["recalibration"] | {"recalibration", "io"} - {"report"}
MAY_IMPORT["cli"] |= {"online", "report", "io", "synthetic", "testing"}
NOT_IN_CORE = ("nlopt", "optimistix", "equinox")
# Rooms that use the core as anybody could: what their files import from other rooms are public names of these rooms.
# The second part: what they need of the commands' own helpers, which are nobody's room.
PUBLIC_FACE_ONLY: dict[str, set[str]] = {
    "synthetic": {"_errors"},
    "online": {"_arrays", "_errors"},
}


def imports_in(code: str, package: str) -> Iterator[str]:
    """Every dotted name that `code`, a module of `package`, imports: modules, and names from modules."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            module = ".".join([*above, *([node.module] if node.module else [])])
            yield from (f"{module}.{alias.name}" for alias in node.names)


@cache
def imports_of(path: Path) -> list[str]:
    package = ".".join(path.relative_to(path.parents[len(path.parts) - len(ROOT.parts) - 2]).parts[:-1])
    return list(imports_in(path.read_text(), package))


def modules(folder: Path) -> list[Path]:
    return [path for path in sorted(folder.rglob("*.py")) if "__pycache__" not in path.parts]


def layer_of(name: str) -> str | None:
    """The package of the core that a dotted name leads into; private top-level modules as they are."""
    parts = name.split(".")
    return parts[1] if parts[0] == "stereorecal" and len(parts) > 1 else None


def test_imports_are_read():
    """The reader itself, on every form of import."""
    code = (
        "import a.b as c\nfrom d import e, f as g\nfrom . import h\nfrom .i import j\nfrom ..k import l\n"
        "def late():\n    if True:\n        from m.n import o\n"
    )
    found = set(imports_in(code, "p.q"))
    assert found == {"a.b", "d.e", "d.f", "p.q.h", "p.q.i.j", "p.k.l", "m.n.o"}
    assert "stereorecal.scoring.host.score" in imports_of(CORE / "comparison" / "_trial.py")


def test_every_package_has_its_place():
    packages = {path.name for path in CORE.iterdir() if (path / "__init__.py").exists()}
    assert packages == set(MAY_IMPORT)


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_imports_run_one_way(package: str):
    private = {path.stem for path in CORE.glob("_[!_]*.py")} if package != "report" else set()
    allowed = MAY_IMPORT[package] | private | {package}
    allowed |= {"InputError"} if package in PUBLIC_FACE_ONLY else set()
    paths = modules(CORE / package)
    assert paths
    for path in paths:
        for name in imports_of(path):
            layer = layer_of(name)
            assert name != "stereorecal", f"{path}: imports the whole library"
            assert layer is None or layer in allowed, f"{path}: {package} must not import {name}"


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_there_is_no_circle():
    """Not even one that only a type checker walks: every module can be read after those that it imports."""
    names = {module_name(path): path for path in modules(CORE)}
    graph = {
        name: {
            found
            for imported in imports_of(path)
            for found in (imported, imported.rpartition(".")[0])
            if found in names and names[found].name != "__init__.py"
        }
        - {name}
        for name, path in names.items()
    }
    graph["a"], graph["b"] = {"b"}, {"a"}
    with pytest.raises(CycleError):
        TopologicalSorter(graph).prepare()
    del graph["a"], graph["b"]
    TopologicalSorter(graph).prepare()


def test_no_circle_between_packages():
    """A package is read before those that are imported from within it."""
    packages = {module_name(path.parent / "__init__.py") for path in CORE.rglob("__init__.py")} - {"stereorecal"}

    def package_of(name: str) -> str | None:
        while name and name not in packages:
            name = name.rpartition(".")[0]
        return name or None

    graph: dict[str, set[str]] = {}
    for path in modules(CORE):
        here = package_of(module_name(path))
        if here is not None:
            graph.setdefault(here, set()).update({package_of(name) for name in imports_of(path)} - {here, None})
    inside = {name: {other for other in found if not other.startswith(f"{name}.")} for name, found in graph.items()}
    TopologicalSorter(inside).prepare()


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_private_modules_stay_in_their_package(package: str):
    for path in modules(CORE / package):
        for name in imports_of(path):
            parts = name.split(".")
            hidden = [part for part in parts[1:] if part.startswith("_")]
            assert parts[0] != "stereorecal" or not hidden or parts[1] in (package, hidden[0]), f"{path}: {name}"


def public_names(package: str) -> set[str]:
    """What the `__init__` of a package re-exports; a package that has only public modules offers those."""
    init = CORE.joinpath(*package.split(".")[1:]) / "__init__.py"
    init = init if not init.with_suffix(".pyi").exists() else init.with_suffix(".pyi")
    exported = {
        alias.asname
        for node in ast.walk(ast.parse(init.read_text()))
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.asname
    }
    return exported | {path.stem for path in init.parent.iterdir() if not path.stem.startswith("_")}


@pytest.mark.parametrize("package", PUBLIC_FACE_ONLY)
def test_some_use_the_core_as_anybody_could(package: str):
    for path in modules(CORE / package):
        for name in imports_of(path):
            parts = name.split(".")
            if parts[0] != "stereorecal" or parts[1] in (package, *PUBLIC_FACE_ONLY[package], "InputError"):
                continue
            assert not any(part.startswith("_") for part in parts), f"{path}: {name} is private"
            if len(parts) > 2:
                assert parts[2] in public_names(".".join(parts[:2])), f"{path}: {name} is no public name"


def test_few_modules_stand_at_the_top():
    assert len(list(CORE.glob("*.py"))) <= 8


def test_private_modules_at_the_top_know_no_package():
    paths = list(CORE.glob("_[!_]*.py"))
    assert paths
    for path in paths:
        layers = {layer_of(name) for name in imports_of(path)} - {None}
        assert not layers & set(MAY_IMPORT), f"{path}: imports {layers}"


def test_the_core_imports_no_plugin():
    for path in modules(CORE):
        for name in imports_of(path):
            top = name.partition(".")[0]
            assert not top.startswith("stereorecal_"), f"{path}: imports the plug-in {name}"
            assert top not in NOT_IN_CORE, f"{path}: imports {name}"


def test_plugins_import_public_names_only():
    paths = [path for plugin in PLUGINS for path in modules(plugin)]
    assert paths
    for path in paths:
        for name in imports_of(path):
            if name.partition(".")[0] == "stereorecal":
                hidden = [part for part in name.split(".") if part.startswith("_")]
                assert not hidden, f"{path}: {name} is private"


def test_private_names_come_into_tests_by_two_kits():
    kits = {"parts_of_estimates", "parts_of_repairs"}
    for path in modules(ROOT / "tests"):
        if path.stem not in kits and path.parent.name != "benchmarks":
            for name in imports_of(path):
                hidden = [part for part in name.split(".") if part.startswith("_")]
                assert not name.startswith("stereorecal.") or not hidden, f"{path}: {name} is private"


def tool(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", *words], cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("words", [("check",), ("format", "--check")], ids=" ".join)
def test_ruff(words: tuple[str, ...]):
    done = tool("ruff", *words, "--no-cache", ".")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_pyright():
    started = tool("pyright", "--version")
    if started.returncode != 0:
        pytest.skip(f"pyright's node does not start: {started.stderr.strip().splitlines()[-1:]}")
    done = tool("pyright", "--pythonpath", sys.executable)
    assert done.returncode == 0, done.stdout + done.stderr
