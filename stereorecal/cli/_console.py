"""Where tables and lines go."""

import re
import sys
import textwrap

from rich.console import Console

from stereorecal.report.comparison_tables import WIDE


def table_console(wide: int = WIDE) -> Console:
    """Stdout: as wide as the terminal, or `wide` columns where it is none."""
    return _Console(width=None if sys.stdout.isatty() else wide)


def print_lines(text: object) -> None:
    """Print lines. On a terminal, one that is too long is folded between words, below what its first word is about; a
    file or a pipe gets it whole, as programs expect."""
    lines = str(text).splitlines()
    if sys.stdout.isatty():
        width = table_console().width
        lines = [folded for line in lines for folded in _folded(line, width)]
    print("\n".join(lines))


def _folded(line: str, width: int) -> list[str]:
    about = re.match(r"\S.{0,10}? {2,}", line)
    indent = " " * (about.end() if about is not None and about.end() < width // 3 else 2)
    together = re.sub(r"(?<=±) | (?=%)", "\u00a0", line)
    folded = textwrap.wrap(together, width, subsequent_indent=indent, break_long_words=False) or [""]
    return [one.replace("\u00a0", " ") for one in folded]


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Called where rich has caught it, and would end the process: what is left to be saved would be lost."""
        raise  # noqa: PLE0704
