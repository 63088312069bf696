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

    def table(heads: Sequence[str], letters: int) -> Table:
        about = None if title is None else Text(title)
        made = Table(box=box.SIMPLE_HEAD, title=about, title_justify="left", padding=(0, 1, 0, 0), pad_edge=False)
        for head in heads:
            made.add_column(head, justify="left" if head in words else "right", no_wrap=True)
        for row in rows:
            made.add_row(*(Text(_folded(row[head], letters) if head in words else row[head]) for head in heads))
        return made

    def widest(heads: Sequence[str], least: int) -> Table | None:
        """The widest layout that fits, with so many letters a line or more."""
        tables = (table(heads, letters) for letters in _LETTERS if letters >= least)
        return next((one for one in tables if Console(width=10_000).measure(one).maximum <= width), None)

    if whole := widest(heads, _TOGETHER if len(parts) > 1 else _WHOLE):
        return [whole], []
    tables, dropped = [], []
    for part in parts:
        others = {head for one in parts if one is not part for head in one}
        kept = [head for head in heads if head not in others]
        may = [head for head in least_missed if head in kept]
        while may and not widest(kept, _WHOLE):
            dropped.append(may[0])
            kept.remove(may.pop(0))
        tables.append(widest(kept, _LETTERS[-1]) or table(kept, _LETTERS[-1]))
    return tables, list(dict.fromkeys(dropped))


def _folded(text: str, letters: int) -> str:
    """The text in lines of so many letters; a word is broken only where it is a long name."""
    whole = text.replace("± ", "±\u00a0")  # stays on one line
    most = max(letters, _WORD if letters > _LETTERS[-1] else _LETTERS[-2])
    lines = (textwrap.wrap(line, most) for line in textwrap.wrap(whole, letters, break_long_words=False))
    return "\n".join(part for parts in lines for part in parts).replace("\u00a0", " ")
