"""Where a Rerun recording goes: into memory, for a file, or to the viewer.

Needs rerun-sdk: pip install 'stereorecal[rerun]'.
"""

import os
import sys
from importlib.util import find_spec
from pathlib import Path

import rerun  # pyright: ignore[reportMissingImports]: an extra
from rerun import MemoryRecording, RecordingStream  # pyright: ignore[reportMissingImports]: an extra
from rerun.blueprint import Blueprint  # pyright: ignore[reportMissingImports]: an extra

_APPLICATION = "stereorecal"


class NoViewer(RuntimeError):
    """The viewer cannot be shown; the message is one sentence that says what to do."""


def memory_stream(layout: Blueprint, name: str) -> tuple[RecordingStream, MemoryRecording]:
    """A recording in memory, and what gives its bytes, those of an .rrd file: `drain_as_bytes()`. The layout is what
    the viewer shows at first."""
    stream = RecordingStream(_APPLICATION)
    memory = stream.memory_recording()
    _describe(stream, layout, name)
    return stream, memory


def viewer_stream(layout: Blueprint, name: str) -> RecordingStream:
    """A recording that Rerun's viewer shows as it grows; the viewer is started, and stays when the program ends."""
    check_screen()
    stream = RecordingStream(_APPLICATION)
    try:
        rerun.spawn(recording=stream, executable_path=_viewer(), hide_welcome_screen=True)
        _describe(stream, layout, name)
        stream.flush()  # waits for the viewer
    except RuntimeError as error:
        why = str(error).partition("\n")[0]
        raise NoViewer(f"Rerun's viewer does not start ({why}); write an .rrd file, and open that.") from error
    return stream


def check_screen() -> None:
    """Refuse a session that has no screen."""
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise NoViewer(
            "there is no screen for Rerun's viewer (DISPLAY is not set); write an .rrd file, and open it where there "
            "is one: rerun FILE"
        )


def _viewer() -> str | None:
    """The viewer that came with rerun-sdk: PATH has it only where the environment is activated. None: not found."""
    found = find_spec("rerun_cli")
    if found is None or found.origin is None:
        return None
    viewer = Path(found.origin).with_name("rerun.exe" if sys.platform == "win32" else "rerun")
    return str(viewer) if viewer.is_file() else None


def _describe(stream: RecordingStream, layout: Blueprint, name: str) -> None:
    stream.send_recording_name(name or _APPLICATION)
    stream.send_blueprint(layout)
