"""Lines on a terminal: none too long, none cut; whole ones elsewhere."""

from pathlib import Path

import pytest

WIDTHS = (60, 80)


@pytest.fixture
def lines(command, clean_scene: Path) -> list[str]:
    """What `score` tells a pipe: whole lines, short ones and long ones."""
    found = command("score", clean_scene).out.splitlines()
    assert min(map(len, found)) < min(WIDTHS) < max(WIDTHS) < max(map(len, found))
    return found


@pytest.mark.parametrize("width", WIDTHS)
def test_long_lines_are_folded_on_a_terminal(monkeypatch, command, clean_scene: Path, lines, terminal, width: int):
    terminal("stdout")
    monkeypatch.setenv("COLUMNS", str(width))
    folded = command("score", clean_scene).out.splitlines()
    assert all(len(line) <= width for line in folded)
    assert " ".join(" ".join(folded).split()) == " ".join(" ".join(lines).split())
    assert {line for line in lines if len(line) <= width} <= set(folded)  # short ones stay as they are
    (first,) = (number for number, line in enumerate(folded) if line.startswith("matched "))
    below = len("matched  ")  # what the first word is about
    assert folded[first + 1].startswith(" " * below)
    assert folded[first + 1][below] != " "
