"""Figures as `<svg>` elements that take their text colour from the page around them."""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

# From the palette of Okabe and Ito, safe for colour-blind readers; contrast of at least 3:1 on white and on black.
COLOURS = ("#0072b2", "#d55e00", "#009e73")
MARKERS = ("o", "s", "^")
INK = "#010203"  # placeholder for the text colour of the page
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "font.size": 11,
    "figure.constrained_layout.use": True,
    "legend.frameon": False,
    **dict.fromkeys(("axes.spines.top", "axes.spines.right"), False),
    **dict.fromkeys(("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), INK),
}


@contextmanager
def style(salt: Any) -> Iterator[None]:
    """Around the making of a figure and its `svg`.

    Args:
        salt: what the figure shows: ids are unique on a page, and the same each time.
    """
    with rc_context({**_STYLE, "svg.hashsalt": repr(salt)}):
        yield


def svg(figure: Figure, alternative: str) -> str:
    """The figure as an `<svg>` element.

    Args:
        alternative: what it shows, for those who do not see it.
    """
    file = io.StringIO()
    figure.savefig(file, format="svg", transparent=True, metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    text = file.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r' id="[A-Za-z0-9]+(\.[a-z0-9]+)*_\d+"', "", text)  # "axes_1": not unique on a page
    text = re.sub(f"(fill|stroke): {INK}", r"\1: currentColor", text)
    return text.replace("<svg", f'<svg role="img" aria-label="{escape(alternative)}"', 1)
