"""A state as a file: JSON for what it is made of, NumPy arrays beside it, nothing that could run when it is read."""

import io
import json
import math
import time
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import InputError, MatcherError
from stereorecal.decision import Tolerances
from stereorecal.estimation import Normal
from stereorecal.geometry import Camera, StereoRig, View, same_rig
from stereorecal.io import write_bytes
from stereorecal.matching import AbstractMatcher, matcher, matchers, name_of
from stereorecal.online._config import Config, Event, Kind
from stereorecal.online._filter import FilterEstimate, Measurement
from stereorecal.online._state import State
from stereorecal.recalibration import Progress
from stereorecal.recordings import Pair
from stereorecal.scoring.host import Corners

SCHEMA = "stereorecal.state/16"
_KNOWN: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        State,
        Config,
        Tolerances,
        FilterEstimate,
        Measurement,
        Normal,
        Corners,
        Progress,
        StereoRig,
        Camera,
        View,
        Pair,
        Kind,
    )
}
# What zipfile, NumPy and the classes raise for what is damaged; RuntimeError for flags that no archive of ours has.
_DAMAGED = (ValueError, LookupError, TypeError, AttributeError, RuntimeError, EOFError, OSError, MemoryError)
_DAMAGED += (zipfile.BadZipFile, zlib.error)
_ROUNDING = 1e-6  # of a calibration that has been written with some digits less
_ANEW = "remove it, or name another file, to start again"


def save(state: State, path: str | Path) -> None:
    """Write a state, whole or not at all: after a loss of power the file holds the last one that was written. Of images
    it holds only those that a repair waits for.

    Raises:
        InputError: if the place cannot be written to, or the state holds a matcher that is not installed.
    """
    arrays: dict[str, np.ndarray] = {}
    content = {"schema": SCHEMA, "state": _encoded(state.alone(), arrays)}
    arrays["content"] = np.frombuffer(json.dumps(content).encode(), np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # pyright: ignore[reportArgumentType]
    write_bytes(path, buffer.getvalue())


def load(path: str | Path, rig: StereoRig | None = None) -> State:
    """The state in a file that `save` wrote; steps go on from it, with a repair under way. What the pairs
    before the break show is not compared with those after it: how the rig turned and moved meanwhile is not known.

    Args:
        rig: the calibration at hand, which must be the one that the state began with, or one that it uses or has used:
            a state knows nothing of a new one.

    Raises:
        InputError: if the file cannot be read, is of another version or of another calibration, or its matcher is not
            installed.
        MatcherError: if its matcher cannot be loaded.
    """
    state = _loaded(path)
    if rig is not None and not any(
        same_rig(rig.side_by_side(), known, _ROUNDING)
        for known in (state.initial, state.rig, *map(state.rig_at, state.previous))
    ):
        raise InputError(
            f"{path}: the state belongs to another calibration than the given one; name another file to start again "
            "with this one."
        )
    return state


def _loaded(path: str | Path) -> State:
    try:
        whole = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error}); check the path.") from error
    try:
        with np.load(io.BytesIO(whole), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        content = json.loads(arrays["content"].tobytes())
        if content["schema"] == SCHEMA:
            return _decoded(content["state"], arrays).alone()
    except InputError as error:  # such as: a matcher that is not installed
        raise InputError(f"{path}: {error}") from error
    except MatcherError:
        raise
    except _DAMAGED as error:
        raise InputError(f"{path}: is no state of this library, or cut short; {_ANEW}.") from error
    raise InputError(f"{path}: the state is of version {content['schema']!r}, not {SCHEMA!r}; {_ANEW}.")


def _encoded(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """The value as JSON; arrays go into `arrays`, and leave their names."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if hasattr(value, "__array__"):
        name = f"a{len(arrays)}"
        arrays[name] = np.asarray(value)
        return {"array": name}
    if isinstance(value, tuple):
        return [_encoded(item, arrays) for item in value]
    kind = type(value).__name__
    if isinstance(value, Enum) and _KNOWN.get(kind) is type(value):
        return {"of": kind, "name": value.name}
    if isinstance(value, AbstractMatcher) and name_of(value) in matchers():
        return {"matcher": name_of(value), "with": _parts(value, arrays)}
    if _KNOWN.get(kind) is not type(value):
        raise InputError(f"a {kind} cannot be saved; use a matcher that is installed, such as sr.SAD().")
    return {"of": kind, "with": _parts(value, arrays)}


def _parts(value: Any, arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    # Where pixels and calibrations came from is not kept: the files may be gone by then.
    names = [part.name for part in fields(value) if part.init and part.name not in ("origin", "source")]
    return {name: _encoded(getattr(value, name), arrays) for name in names}


def _decoded(value: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if isinstance(value, list):
        return tuple(_decoded(item, arrays) for item in value)
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[value["array"]]
    if "matcher" in value:
        return matcher(value["matcher"], **{name: _decoded(item, arrays) for name, item in value["with"].items()})
    kind = _KNOWN[value["of"]]
    if "name" in value:
        return kind[value["name"]]
    return kind(**{name: _decoded(item, arrays) for name, item in value["with"].items()})


@dataclass
class StateFile:
    """Where states are saved. A place that cannot be written to, such as a full disk, is told once, and tried again.

    Attributes:
        path: of the file; None saves nothing.
        every: seconds between two attempts, at least.
        written: the state that the file holds, or that need not be written.
    """

    path: str | Path | None
    every: float
    written: State
    _tried: float = -math.inf
    _failed: bool = False

    def keep(self, state: State, *, now: bool) -> tuple[Event, ...]:
        """Save a state if that is due, or `now`; returns what is to be told of it."""
        if self.path is None or state is self.written or not (now or time.monotonic() - self._tried >= self.every):
            return ()
        self._tried, failed = time.monotonic(), self._failed
        try:
            save(state, self.path)
        except InputError as error:
            self._failed = True
            return () if failed else (Event(state.frame, Kind.NOT_SAVED, str(error)),)
        self.written, self._failed = state, False
        return (Event(state.frame, Kind.SAVED),) if failed else ()
