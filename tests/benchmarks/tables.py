"""The command lines of benchmarks, and the tables that they print."""

import argparse
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table


def command_line(about: str | None) -> argparse.ArgumentParser:
    """A parser whose help is the text at the head of a benchmark."""
    return argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)


def size(text: str) -> tuple[int, int]:
    """What is said as WIDTHxHEIGHT."""
    width, height = map(int, text.split("x"))
    return width, height


def words(text: str) -> list[str]:
    """What stands between commas."""
    return [word for word in text.split(",") if word]


def among(name: str, wanted: Sequence[str]) -> bool:
    """Whether a name has one of the wanted parts, or none are named."""
    return not wanted or any(part in name for part in wanted)


def table_of(heads: str, *, title: str | None = None, left: int = 1) -> Table:
    """A table with these heads, " | " between them: so many columns of words, then numbers."""
    table = Table(title=title, title_justify="left", box=None)
    for index, head in enumerate(heads.split(" | ")):
        table.add_column(head, justify="left" if index < left else "right")
    return table


def show(*tables: Table) -> None:
    """Print them, however wide."""
    Console(width=260).print(*tables)
