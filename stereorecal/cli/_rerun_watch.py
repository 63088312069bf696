"""A watch in Rerun: shown while it runs, and written when it ends."""

from collections.abc import Callable

from stereorecal._errors import as_input_error, extra
from stereorecal.cli._live_view import AXIS_UNITS
from stereorecal.cli._repair_commands import MonitorOptions
from stereorecal.io import write_bytes
from stereorecal.online import FAR, Reading, Stepped, reading

_CURVES = {
    **{axis: f"{axis} [{unit}]" for axis, unit in AXIS_UNITS.items()},
    "epipolar_error": "epipolar error [px]",
    "depth_error": f"depth error at {FAR} baselines [%]",
    "delay": "right shutter late by [frames]",
}


def rerun_watch(options: MonitorOptions, name: str) -> tuple[Callable[[Stepped], None], Callable[[], None]]:
    """Two functions: one to call with each step, and one that writes the recording, whole or not at all. Both do
    nothing unless the options ask for a recording or the viewer.

    Raises:
        InputError: if Rerun is not installed, or its viewer does not start.
    """
    if options.rrd is None and not options.show:
        return lambda stepped: None, lambda: None
    with extra("rerun", "a Rerun recording"):
        from stereorecal.report.rerun_streams import NoViewer, memory_stream, viewer_stream
        from stereorecal.report.watch_recording import log_curve_styles, log_reading, watch_layout
    layout = watch_layout(_CURVES)
    memory, streams = None, []
    if options.rrd is not None:
        stream, memory = memory_stream(layout, name)
        streams.append(stream)
    if options.show:
        with as_input_error(NoViewer):
            streams.append(viewer_stream(layout, name))
    for stream in streams:
        log_curve_styles(stream, _CURVES)

    def log(stepped: Stepped) -> None:
        curves, events = _curves(reading(stepped.state)), [str(event) for event in stepped.events]
        for stream in streams:
            log_reading(stream, stepped.state.frame - 1, curves, events)

    def save() -> None:
        if memory is not None and options.rrd is not None:
            write_bytes(options.rrd, memory.drain_as_bytes(), replace=options.force)

    return log, save


def _curves(found: Reading) -> dict[str, tuple[float, float, float]]:
    """Value, low and high end of the 95 % interval, by the name of the curve; units as in `_CURVES`."""
    intervals = {
        **found.axes,
        "epipolar_error": found.rows_px,
        "depth_error": found.depth_percent[FAR],
        "delay": found.delay,
    }
    return {entity: (one.value, one.low, one.high) for entity, one in intervals.items()}
