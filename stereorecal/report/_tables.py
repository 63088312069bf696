"""Tables that fit the width of a terminal: words are folded, then the table is split, then columns are left out."""

import textwrap
from collections.abc import Collection, Mapping, Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

_LETTERS = (60, 40, 30, 21, 16, 12, 8, 6)  # of a line of words, from the widest layout to the narrowest
_TOGETHER = 21  # letters a line, at least; before words are folded more, a table is split
_WHOLE = 12  # letters a line, at least; before words are folded more, columns are left out
_WORD = 12  # letters of a word that is not broken, but in the narrowest layout

Rows = Sequence[Mapping[str, str]]


def fitted(
    rows: Rows,
    width: int,
    words: Collection[str],
    *,
    title: str | None = None,
    parts: Sequence[Collection[str]] = ((),),
    least_missed: Sequence[str] = (),
) -> tuple[list[Table], list[str]]:
    """A table, or its parts, in `width` columns of a terminal, and the heads of what is left out.

    Args:
        rows: the cells of each, by their heads, which are those of the first.
        words: heads of columns that are aligned left and folded; others are numbers.
        parts: heads of what is split where the table is too wide; others stand in each part.
        least_missed: heads of columns that may be left out, in that order.
    """
    heads = list(rows[0])
    least = _TOGETHER if len(parts) > 1 else _WHOLE
    if table := _first_that_fits(rows, heads, width, words, title, [most for most in _LETTERS if most >= least]):
        return [table], []
    tables, dropped = [], []
    for part in parts:
        others = {head for one in parts if one is not part for head in one}
        kept = [head for head in heads if head not in others]
        may = [head for head in least_missed if head in kept]
        letters = [most for most in _LETTERS if most >= _WHOLE]
        while may and not _first_that_fits(rows, kept, width, words, title, letters):
            dropped.append(may[0])
            kept.remove(may.pop(0))
        table = _first_that_fits(rows, kept, width, words, title, _LETTERS)
        tables.append(table or _table(rows, kept, words, title, _LETTERS[-1]))
    return tables, list(dict.fromkeys(dropped))


def _first_that_fits(
    rows: Rows, heads: Sequence[str], width: int, words: Collection[str], title: str | None, letters: Sequence[int]
) -> Table | None:
    tables = (_table(rows, heads, words, title, most) for most in letters)
    return next((table for table in tables if Console(width=10_000).measure(table).maximum <= width), None)


def _table(rows: Rows, heads: Sequence[str], words: Collection[str], title: str | None, letters: int) -> Table:
    about = None if title is None else Text(title)
    table = Table(box=box.SIMPLE_HEAD, title=about, title_justify="left", padding=(0, 1, 0, 0), pad_edge=False)
    for head in heads:
        table.add_column(head, justify="left" if head in words else "right", no_wrap=True)
    for row in rows:
        table.add_row(*(Text(_folded(row[head], letters) if head in words else row[head]) for head in heads))
    return table


def _folded(text: str, letters: int) -> str:
    """The text in lines of so many letters; a word is broken only where it is a long name."""
    whole = text.replace("± ", "±\u00a0")  # stays on one line
    most = max(letters, _WORD if letters > _LETTERS[-1] else _LETTERS[-2])
    lines = (textwrap.wrap(line, most) for line in textwrap.wrap(whole, letters, break_long_words=False))
    return "\n".join(part for parts in lines for part in parts).replace("\u00a0", " ")
