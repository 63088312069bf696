"""A watch as a Rerun recording: intervals over the pairs, and events.

Needs rerun-sdk: pip install 'stereorecal[rerun]'.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr  # pyright: ignore[reportMissingImports]: an extra
import rerun.blueprint as rrb  # pyright: ignore[reportMissingImports]: an extra

_TIMELINE = "pair"
_COLOURS = ((0, 114, 178), (150, 150, 150), (150, 150, 150))
_ACROSS = 3  # columns of curves


def watch_layout(curves: Mapping[str, str]) -> rrb.Blueprint:
    """What the viewer shows at first: a view for each curve, with its title by entity, and the events below."""
    hidden = rrb.PlotLegend(visible=False)
    views = [
        rrb.TimeSeriesView(origin=f"/{entity}", name=f"{title}, with its 95 % interval", plot_legend=hidden)
        for entity, title in curves.items()
    ]
    events = rrb.TextLogView(origin="/events", name="events")
    return rrb.Blueprint(
        rrb.Vertical(rrb.Grid(*views, grid_columns=_ACROSS), events, row_shares=[4, 1]),
        rrb.TimePanel(timeline=_TIMELINE, state="collapsed"),
        collapse_panels=True,
    )


def log_curve_styles(stream: rr.RecordingStream, curves: Mapping[str, str]) -> None:
    """Log how curves look: the estimate strong, the ends of its 95 % interval thin."""
    for entity in curves:
        names = ["estimate", "95 % from", "95 % to"]
        stream.log(entity, rr.SeriesLines(names=names, colors=_COLOURS, widths=[2.0, 1.0, 1.0]), static=True)


def log_reading(
    stream: rr.RecordingStream, pair: int, curves: Mapping[str, tuple[float, float, float]], events: Sequence[str]
) -> None:
    """Log what is known after a pair: by entity, value and both ends of its interval, if they are finite; and what
    happened, in words."""
    stream.set_time(_TIMELINE, sequence=pair)
    for entity, values in curves.items():
        if np.isfinite(values).all():
            stream.log(entity, rr.Scalars(values))
    for event in events:
        stream.log("events", rr.TextLog(event, level="INFO"))
