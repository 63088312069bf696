"""Lines on a terminal: none too long, none cut; whole ones elsewhere."""

import pytest

from stereorecal.cli._terminal import print_lines

LONG = "expect   epipolar error (RMS) 0.09 px over the view; depth at 10 B -4.7 % to +5.5 %"
TEXT = f"accepted: better\n{LONG}\n\nx       -356.000 ->  -356.000 mm  changed by   +0.000"


@pytest.mark.parametrize("width", [60, 80])
def test_long_lines_are_folded_on_a_terminal(monkeypatch, capsys, terminal, width: int):
    terminal("stdout")
    monkeypatch.setenv("COLUMNS", str(width))
    print_lines(TEXT)
    lines = capsys.readouterr().out.splitlines()
    assert all(len(line) <= width for line in lines)
    assert [lines[0], *lines[-2:]] == [TEXT.splitlines()[0], *TEXT.splitlines()[-2:]]  # short ones stay as they are
    assert lines[2].startswith(" " * 9)
    assert lines[2][9] != " "
    assert " ".join(lines[1:-2]).split() == LONG.split()


def test_a_pipe_gets_whole_lines(capsys):
    print_lines(TEXT)
    assert capsys.readouterr().out == TEXT + "\n"
