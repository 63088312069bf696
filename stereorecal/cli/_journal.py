"""A comparison on the disk while it runs: one that is killed has its finished trials there."""

import time
from contextlib import suppress
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.comparison import Comparison
from stereorecal.io import json_text, write_text

_SHARE = 0.05  # of the time, at most, goes into saving


class Journal:
    """Saves what is finished to the file of --json, whole each time, if that is a file."""

    def __init__(self, target: str | None, *, force: bool):
        file = target is not None and target != "-" and (Path(target).is_file() or not Path(target).exists())
        self._target = target if file else None
        self.force = force  # whether what is there may be replaced: it may, once it is this run's own
        self._next = 0.0

    def __call__(self, comparison: Comparison) -> None:
        started = time.monotonic()
        if self._target is None or started < self._next:
            return
        with suppress(InputError):  # said, and printed, at the end
            write_text(self._target, json_text(comparison.as_dict()), replace=self.force)
            self.force = True
        ended = time.monotonic()
        self._next = ended + (ended - started) / _SHARE
