"""Tables for a terminal: words are folded where it is narrow, numbers stay whole."""

from collections.abc import Collection, Mapping, Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

Rows = Sequence[Mapping[str, str]]


def tables_of(
    rows: Rows, width: int, words: Collection[str], *, title: str | None = None, parts: Sequence[Collection[str]] = ()
) -> list[Table]:
    """A table, or its parts where the whole is wider than `width` columns of a terminal.

    Args:
        rows: the cells of each, by their heads, which are those of the first.
        words: heads of columns that are aligned left and folded; others are numbers.
        parts: heads of what is split; others stand in each part.
    """
    every = {head for part in parts for head in part}
    whole = _table(rows, list(rows[0]), words, title)
    if not parts or Console(width=10_000).measure(whole).minimum <= width:
        return [whole]
    return [
        _table(rows, [head for head in rows[0] if head in part or head not in every], words, title) for part in parts
    ]


def _table(rows: Rows, heads: Sequence[str], words: Collection[str], title: str | None) -> Table:
    about = None if title is None else Text(title)
    made = Table(box=box.SIMPLE_HEAD, title=about, title_justify="left", padding=(0, 1, 0, 0), pad_edge=False)
    for head in heads:
        if head in words:
            made.add_column(head, overflow="fold")
        else:
            lines = "\n".join([head, *(row[head] for row in rows)]).split("\n")
            made.add_column(head, justify="right", no_wrap=True, min_width=max(map(len, lines)))
    for row in rows:
        made.add_row(*(Text(row[head]) for head in heads))
    return made
