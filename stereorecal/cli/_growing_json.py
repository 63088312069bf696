"""Comparisons on the disk while they run: what is killed has its finished trials there."""

import time
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

from stereorecal._errors import InputError
from stereorecal.io import json_text, write_text

_SHARE = 0.05  # of the time, at most, goes into saving


class _Table(Protocol):
    def as_dict(self) -> dict[str, Any]: ...


class GrowingJson:
    """A comparison in the file of --json, if that is a file: written whole, again and again."""

    def __init__(self, target: str | None, *, force: bool):
        file = target is not None and target != "-" and (Path(target).is_file() or not Path(target).exists())
        self._target = target if file else None
        self.force = force  # whether what is there may be replaced: it may, once it is this run's own
        self._next = 0.0

    def __call__(self, table: _Table) -> None:
        started = time.monotonic()
        if self._target is None or started < self._next:
            return
        with suppress(InputError):  # said, and printed, at the end
            write_text(self._target, json_text(table.as_dict()), replace=self.force)
            self.force = True
        ended = time.monotonic()
        self._next = ended + (ended - started) / _SHARE
