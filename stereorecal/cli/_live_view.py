"""The live view of a rig that is watched: its axes, its health over time, what happened."""

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from rich.console import Group
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from stereorecal.online import FAR, Reading, Stepped, reading
from stereorecal.recalibration import Condition, Interval

_COLOURS = {Condition.HEALTHY: "green", Condition.REPAIR: "red", Condition.CANNOT_TELL: "yellow"}
_BARS = "▁▂▃▄▅▆▇█"
_LONG = 72  # readings in the curves
_EVENTS = 8
AXIS_UNITS = {"pitch": "deg", "yaw": "deg", "roll": "deg", "y": "% of B", "z": "% of B"}


def lines(stepped: Stepped) -> None:
    """The events of a step, a line each."""
    for event in stepped.events:
        print(event, flush=True)


@contextmanager
def live(name: str) -> Iterator[Callable[[Stepped], None]]:
    """A view that is drawn anew after each step."""
    history: deque[Reading] = deque(maxlen=_LONG)
    happened: deque[str] = deque(maxlen=_EVENTS)

    def show(stepped: Stepped) -> None:
        history.append(reading(stepped.state))
        happened.extend(str(event) for event in stepped.events)
        screen.update(view(name, stepped.state.frame, list(history), list(happened)), refresh=True)

    with Live(auto_refresh=False) as screen:
        yield show


def view(name: str, pairs: int, history: list[Reading], happened: list[str]) -> Panel:
    """The view after some pairs."""
    last = history[-1]
    table = Table(box=None, padding=(0, 2))
    for title in ("", "estimate", "95 % interval", "over time"):
        table.add_column(title, justify="left" if title in ("", "over time") else "right")
    for axis, found in last.axes.items():
        table.add_row(
            axis, f"{found.value:+.3f} {AXIS_UNITS[axis]}", _interval(found), _curve([h.axes[axis] for h in history])
        )
    table.add_row(
        "row error", f"{last.rows_px.value:.3f} px", _interval(last.rows_px), _curve([h.rows_px for h in history])
    )
    depth = [h.depth_percent[FAR] for h in history]
    table.add_row(f"depth at {FAR} B", f"{depth[-1].value:+.1f} %", _interval(depth[-1]), _curve(depth))
    table.add_row(
        "late by", f"{last.delay.value:+.2f} frames", _interval(last.delay), _curve([h.delay for h in history])
    )
    verdict = Text(f"{pairs} pairs: {last.condition.value}", style=f"bold {_COLOURS[last.condition]}")
    events = Text("\n".join(happened) or "nothing has happened yet", style="dim")
    return Panel(Group(verdict, table, Text(), events), title=name, title_align="left")


def _interval(found: Interval) -> str:
    return f"{found.low:+.3f} … {found.high:+.3f}"


def _curve(values: list[Interval]) -> str:
    """Magnitudes as bars, the largest full; noise that is a tenth of the interval stays low. What is infinite is full,
    what is unknown is empty."""
    known = [size for v in values for size in (abs(v.value), 0.5 * (v.high - v.low)) if np.isfinite(size)]
    most = max([*known, 1e-9])
    shares = np.nan_to_num([abs(v.value) / most for v in values[-40:]], nan=0.0, posinf=1.0)
    return "".join(_BARS[min(int(share * len(_BARS)), len(_BARS) - 1)] for share in shares)
