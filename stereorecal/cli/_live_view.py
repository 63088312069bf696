"""What a watch shows: what to show the rig next, its axes and health over time, what was covered, what happened; as
lines, as a view in a terminal, and in Rerun.
"""

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module

import numpy as np
from rich.console import Group
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from stereorecal._errors import as_input_error
from stereorecal.cli._output_files import check_extra
from stereorecal.cli._repair_commands import MonitorOptions
from stereorecal.io import write_bytes
from stereorecal.online import BAND_EDGES, FAR, PARTS, Advice, Reading, Showing, State, Stepped, Undetermined, reading
from stereorecal.recalibration import DISTANCES, Condition, Interval
from stereorecal.report.number_text import distance

_WORDS = {"epipolar": "epipolar error", "depth": "depth"}
_ROWS, _COLUMNS = ("upper", "", "lower"), ("left", "", "right")
_ALONE = {"upper": "at the top", "lower": "at the bottom", "left": "on the left", "right": "on the right"}

_COLOURS = {Condition.HEALTHY: "green", Condition.REPAIR: "red", Condition.CANNOT_TELL: "yellow"}
_BARS = "▁▂▃▄▅▆▇█"
_LONG = 72  # readings in the curves
_EVENTS = 8
_CURVES = {  # what is shown over time: title, format and unit
    **{axis: (axis, "+.3f", "deg") for axis in ("pitch", "yaw", "roll")},
    **{axis: (axis, "+.3f", "% of B") for axis in ("y", "z")},
    "epipolar_error": ("epipolar error", ".3f", "px"),
    "depth_error": ("depth at {far}", "+.1f", "%"),
    "delay": ("right late by", "+.2f", "frames"),
}


def next_step(found: Advice, baseline: float) -> str:
    """What to do next; `baseline` in metres."""
    if found.blind:
        return "turn the rig towards something with texture, in good light"
    if found.show is not None:
        return _showing(found.show, baseline)
    if any(one.error == "depth" for one in found.undetermined):
        return "nothing to be seen here would tell more of depth; measured distances would (recalibrate --ranges)"
    return "nothing: the answer stands" if found.stands else "go on"


def _showing(show: Showing, baseline: float) -> str:
    if show.motion:
        past = "" if show.distance is None else f" past something {away(show.distance, baseline)}"
        return f"drive on{past}{': depth needs motion' if show.narrows.error == 'depth' else ''}"
    assert show.part is not None
    assert show.distance is not None
    row, column = _ROWS[show.part[0]], _COLUMNS[show.part[1]]
    place = f"in the {row} {column}" if row and column else _ALONE.get(row or column, "in the middle")
    return f"show something {away(show.distance, baseline)}, {place} of the view"


def reason(found: Advice, baseline: float) -> str:
    """What that narrows, and by how much; empty where it narrows nothing."""
    if found.blind or found.show is None:
        return ""
    narrows = found.show.narrows
    after = replace(narrows, half_width=found.show.half_width)
    name = f"{_WORDS[narrows.error]} at {distance(narrows.distance * baseline)}"
    return f"{name}: {_half_width(narrows, baseline)} now, {_half_width(after, baseline)} then"


def undetermined(found: Advice, baseline: float) -> str:
    """What is known less well than matters, such as "epipolar error at 60 cm, 1.2 m (± 1.06 px); depth at 3.6 m (± 25
    cm); axes pitch, yaw"."""
    told = []
    for error, word in _WORDS.items():
        if those := [one for one in found.undetermined if one.error == error]:
            where = ", ".join(distance(one * baseline) for one in sorted(each.distance for each in those))
            told.append(f"{word} at {where} ({_half_width(those[0], baseline)})")
    return "; ".join([*told, f"axes {', '.join(found.axes)}"] if found.axes else told) or "nothing"


def _half_width(one: Undetermined, baseline: float) -> str:
    if one.error == "epipolar":
        return f"± {one.half_width:.2f} px"
    return f"± {distance(0.01 * one.half_width * one.distance * baseline)}"


def away(baselines: float, baseline: float) -> str:
    """The distances that count as one: "within 85 cm", "85 cm to 2.1 m away", "farther than 6.6 m"."""
    lengths = [distance(edge * baseline) for edge in BAND_EDGES]
    band = sum(edge < baselines for edge in BAND_EDGES)
    if band == 0:
        return f"within {lengths[0]}"
    if band == len(BAND_EDGES):
        return f"farther than {lengths[-1]}"
    low, high = lengths[band - 1 : band + 1]
    number, unit = low.split()
    return f"{number if high.endswith(f' {unit}') else low} to {high} away"


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
    curves = list(map(_curves, history))
    far = distance(FAR * baseline)
    for entity, (title, digits, unit) in _CURVES.items():
        now = curves[-1][entity]
        cells = (title.format(far=far), f"{now.value:{digits}} {unit}", f"{now.low:+.3f} … {now.high:+.3f}")
        table.add_row(*cells, _bars([one[entity] for one in curves]), style="yellow" if entity in found.axes else "")
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


def _bars(values: list[Interval]) -> str:
    """Magnitudes as bars, the largest full; noise that is a tenth of the interval stays low. What is infinite is full,
    what is unknown is empty."""
    known = [size for v in values for size in (abs(v.value), 0.5 * (v.high - v.low)) if np.isfinite(size)]
    most = max([*known, 1e-9])
    shares = np.nan_to_num([abs(v.value) / most for v in values[-40:]], nan=0.0, posinf=1.0)
    return "".join(_BARS[min(int(share * len(_BARS)), len(_BARS) - 1)] for share in shares)


def check_rerun(options: MonitorOptions) -> None:
    """Refuse, before the work is done, a recording that could not be made or shown."""
    for name in ("rrd", "show"):
        check_extra(options, name, "rerun", "stereorecal.report.watch_recording")
    if options.show:
        streams = import_module("stereorecal.report.rerun_streams")
        with as_input_error(streams.NoViewer):
            streams.check_screen()


def rerun_watch(options: MonitorOptions, name: str) -> tuple[Callable[[Stepped], None], Callable[[], None]]:
    """Two functions: one to call with each step, and one that writes the recording, whole or not at all. Both do
    nothing unless the options ask for a recording or the viewer."""
    if options.rrd is None and not options.show:
        return lambda stepped: None, lambda: None
    from stereorecal.report.rerun_streams import NoViewer, memory_stream, viewer_stream
    from stereorecal.report.watch_recording import log_curve_styles, log_reading, watch_layout

    titles = {
        entity: f"{title.format(far=f'{FAR} baselines')} [{unit}]" for entity, (title, _, unit) in _CURVES.items()
    }
    layout = watch_layout(titles)
    memory, streams = None, []
    if options.rrd is not None:
        stream, memory = memory_stream(layout, name)
        streams.append(stream)
    if options.show:
        with as_input_error(NoViewer):
            streams.append(viewer_stream(layout, name))
    for stream in streams:
        log_curve_styles(stream, titles)

    def log(stepped: Stepped) -> None:
        found, events = _curves(reading(stepped.state)), [str(event) for event in stepped.events]
        curves = {entity: (one.value, one.low, one.high) for entity, one in found.items()}
        for stream in streams:
            log_reading(stream, stepped.state.frame - 1, curves, events)

    def save() -> None:
        if memory is not None and options.rrd is not None:
            write_bytes(options.rrd, memory.drain_as_bytes(), replace=options.force)

    return log, save


def _curves(found: Reading) -> dict[str, Interval]:
    """What is drawn over time, by the name of its curve; units as in `_CURVES`."""
    depth = found.depth_percent[FAR]
    return {**found.axes, "epipolar_error": found.rows_px, "depth_error": depth, "delay": found.delay}
