"""Lines on a terminal: none too long, none cut; whole ones elsewhere."""

from pathlib import Path

WIDTHS = (60, 80)


def test_long_lines_are_folded_on_a_terminal(monkeypatch, command, clean_scene: Path, terminal):
    """A pipe is told whole lines, short ones and long ones."""
    lines = command("score", clean_scene).out.splitlines()
    assert min(map(len, lines)) < min(WIDTHS) < max(WIDTHS) < max(map(len, lines))
    terminal("stdout")
    for width in WIDTHS:
        monkeypatch.setenv("COLUMNS", str(width))
        folded = command("score", clean_scene).out.splitlines()
        assert all(len(line) <= width for line in folded)
        assert " ".join(" ".join(folded).split()) == " ".join(" ".join(lines).split())
        assert {line for line in lines if len(line) <= width} <= set(folded)  # short ones stay as they are
        (first,) = (number for number, line in enumerate(folded) if line.startswith("matched "))
        assert folded[first + 1].startswith("  ")
