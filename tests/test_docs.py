"""The pages as a whole: each can be reached, links lead somewhere, public names have their place. (Their code is run by
`docs/conftest.py`, and the site is built by hand.)"""

import ast
import re
from pathlib import Path

import pytest

from stereorecal.cli import parser

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
LINK = re.compile(r"\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```$", re.DOTALL | re.MULTILINE)


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def anchors(page: Path) -> set[str]:
    """The anchors of the headings, as repository pages and MyST make them."""
    heads = re.findall(r"^#+ (.*)$", FENCE.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=name_of)
def test_links_lead_somewhere(page: Path):
    for link in LINK.findall(FENCE.sub("", page.read_text())):
        if link.startswith(("https://", "http://")):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.is_file(), f"{link} leads nowhere"
        assert target.is_relative_to(DOCS) or page.name == "README.md", f"{link} is not on the site"
        assert not anchor or anchor in anchors(target), f"{link}: there is no such heading"


def test_every_page_is_in_a_menu():
    listed = {DOCS / "index.md"}
    for page in PAGES:
        for menu in re.findall(r"^```\{toctree\}$(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE):
            names = [line for line in menu.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{name}.md").resolve() for name in names}
    assert listed == set(PAGES)


def public_names() -> set[str]:
    tree = ast.parse((ROOT / "stereorecal" / "__init__.pyi").read_text())
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    return {alias.name for node in imports for alias in node.names} - {"__version__"}


def test_every_public_name_has_its_place():
    """Once: values and functions on the page of the library, packages on theirs."""
    directive = re.compile(r"^\.\. auto\w+:: stereorecal\.([\w.]+)$", re.MULTILINE)
    names = directive.findall((DOCS / "reference" / "library.md").read_text())
    packages = directive.findall((DOCS / "reference" / "packages.md").read_text())
    names = ["strategies" if name == "strategies.strategies" else name for name in names]
    assert len(names) == len(set(names))
    assert len(packages) == len(set(packages))
    assert set(names) | {name for name in packages if "." not in name} == public_names()


def test_what_contributors_copy_is_there():
    page = (DOCS / "CONTRIBUTING.md").read_text()
    paths = re.findall(r"`((?:stereorecal|plugins|tests|docs)/[\w./-]*)`", page)
    assert len(paths) > 10
    for path in paths:
        assert (ROOT / path).exists(), path


def test_the_command_line_has_its_page():
    page = (DOCS / "reference" / "command-line.md").read_text()
    rows = re.findall(r"^\| `?([\w-]+)`? \|", page, re.MULTILINE)
    (verbs,) = (action.choices for action in parser()._actions if action.metavar == "COMMAND")
    assert set(rows) >= set(verbs)
    assert {int(row) for row in rows if row.isdigit()} == {0, 1, 2, 3, 4, 5, 130}
