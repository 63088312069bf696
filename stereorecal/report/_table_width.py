"""Tables that fit the width of a terminal."""

from collections.abc import Callable, Iterable, Sequence

from rich.console import Console
from rich.table import Table


def width_of(table: Table) -> int:
    """Columns of a terminal that a table takes if nothing is folded."""
    return Console(width=10_000).measure(table).maximum


def first_that_fits(layouts: Iterable[Callable[[], Sequence[Table]]], width: int) -> Sequence[Table]:
    """The tables of the first layout that fit `width` columns; else those of the last."""
    tables: Sequence[Table] = ()
    for layout in layouts:
        tables = layout()
        if all(width_of(table) <= width for table in tables):
            break
    return tables
