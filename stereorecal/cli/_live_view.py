"""The live view of a rig that is watched: what to show next, its axes and health over time, what was covered, what
happened."""

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from rich.console import Group
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from stereorecal.cli._advice_text import away, next_step, reason, undetermined
from stereorecal.online import FAR, PARTS, Advice, Reading, State, Stepped, reading
from stereorecal.recalibration import DISTANCES, Condition, Interval
from stereorecal.report.number_text import distance

_COLOURS = {Condition.HEALTHY: "green", Condition.REPAIR: "red", Condition.CANNOT_TELL: "yellow"}
_BARS = "▁▂▃▄▅▆▇█"
_LONG = 72  # readings in the curves
_EVENTS = 8
AXIS_UNITS = {"pitch": "deg", "yaw": "deg", "roll": "deg", "y": "% of B", "z": "% of B"}


@dataclass
class Lines:
    """Lines of what happens, and of what to show next whenever that changes."""

    said: str | None = None

    def __call__(self, stepped: Stepped, found: Advice) -> None:
        for event in stepped.events:
            print(event, flush=True)
        step = next_step(found, float(stepped.state.initial.baseline))
        if step != self.said:
            print(f"{stepped.state.frame - 1:6d}  next: {step}", flush=True)
        self.said = step


@contextmanager
def live(name: str) -> Iterator[Callable[[Stepped, Advice], None]]:
    """A view that is drawn anew after each step."""
    history: deque[Reading] = deque(maxlen=_LONG)
    happened: deque[str] = deque(maxlen=_EVENTS)

    def show(stepped: Stepped, found: Advice) -> None:
        history.append(reading(stepped.state))
        happened.extend(str(event) for event in stepped.events)
        screen.update(view(name, stepped.state, list(history), found, list(happened)), refresh=True)

    with Live(auto_refresh=False) as screen:
        yield show


def view(name: str, state: State, history: list[Reading], found: Advice, happened: list[str]) -> Panel:
    """The view after some pairs."""
    last, baseline = history[-1], float(state.initial.baseline)
    table = Table(box=None, padding=(0, 2))
    for title in ("", "estimate", "95 % interval", "over time"):
        table.add_column(title, justify="left" if title in ("", "over time") else "right")
    for axis, interval in last.axes.items():
        style = "yellow" if axis in found.axes else ""
        curve = _curve([h.axes[axis] for h in history])
        table.add_row(axis, f"{interval.value:+.3f} {AXIS_UNITS[axis]}", _interval(interval), curve, style=style)
    table.add_row(
        "epipolar error", f"{last.rows_px.value:.3f} px", _interval(last.rows_px), _curve([h.rows_px for h in history])
    )
    depth = [h.depth_percent[FAR] for h in history]
    table.add_row(
        f"depth at {distance(FAR * baseline)}", f"{depth[-1].value:+.1f} %", _interval(depth[-1]), _curve(depth)
    )
    table.add_row(
        "late by", f"{last.delay.value:+.2f} frames", _interval(last.delay), _curve([h.delay for h in history])
    )
    verdict = Text(
        f"{state.frame} pair{'s' * (state.frame > 1)}: {last.condition.value}", style=f"bold {_COLOURS[last.condition]}"
    )
    step = Text(f"Next: {next_step(found, baseline)}", style="bold")
    missing = Text(f"not determined yet: {undetermined(found, baseline)}")
    events = Text("\n".join(happened) or "nothing has happened yet", style="dim")
    parts = (verdict, step, Text(reason(found, baseline), style="dim"), Text(), table, missing, Text())
    return Panel(Group(*parts, _covered(state, baseline), Text(), events), title=name, title_align="left")


def _covered(state: State, baseline: float) -> Table:
    """Thirds of the view and distances, filled where matches have shown something."""
    table = Table(box=None, padding=(0, 2))
    table.add_column("matches so far")
    for away_baselines in DISTANCES:
        table.add_column(away(away_baselines, baseline), justify="center")
    by_row = np.rot90((state.coverage > 0).reshape(*PARTS, -1), -state.initial.turns[0])  # as the image was taken
    for title, row in zip(("top", "middle", "bottom"), by_row, strict=True):
        cells = (" ".join("■" if shown else "·" for shown in of_distance) for of_distance in row.T.tolist())
        table.add_row(title, *cells)
    return table


def _interval(found: Interval) -> str:
    return f"{found.low:+.3f} … {found.high:+.3f}"


def _curve(values: list[Interval]) -> str:
    """Magnitudes as bars, the largest full; noise that is a tenth of the interval stays low. What is infinite is full,
    what is unknown is empty."""
    known = [size for v in values for size in (abs(v.value), 0.5 * (v.high - v.low)) if np.isfinite(size)]
    most = max([*known, 1e-9])
    shares = np.nan_to_num([abs(v.value) / most for v in values[-40:]], nan=0.0, posinf=1.0)
    return "".join(_BARS[min(int(share * len(_BARS)), len(_BARS) - 1)] for share in shares)
