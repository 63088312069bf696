"""Comparisons on the disk while they run: what is killed has its finished trials there."""

import json
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.comparison import Comparison
from stereorecal.comparison.field import FieldTrial, as_trial
from stereorecal.io import json_line, json_text, write_text

_SHARE = 0.05  # of the time, at most, goes into saving
_SUFFIX, _PLACES = ".trials", "places"


class GrowingJson:
    """A comparison of strategies in the file of --json, if that is a file: written whole, again and again."""

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


class TrialJournal:
    """Finished trials, a line each, beside the first file that a comparison by judges writes, until it is finished:
    who is killed goes on where it was. Without a file, nothing is kept.

    An earlier run's is found beside any of the files, whichever of them it wrote.

    Attributes:
        path: of the file; None without one.
        done: the trials that an earlier run finished, by key.
    """

    def __init__(self, places: Sequence[Path], made_with: Mapping[str, Any]) -> None:
        journals = [Path(f"{place}{_SUFFIX}") for place in places]
        self.path = next((path for path in journals if path.exists()), journals[0] if journals else None)
        self.done: dict[str, FieldTrial] = {}
        self._made_with = json.loads(json_line(made_with))
        self._places: list[str] = [str(place.resolve()) for place in places]
        self._written: list[str] = []
        if self.path is not None and self.path.exists():
            self._read(self.path)

    def owns(self, place: Path) -> bool:
        """Whether an earlier run was to write this file, which may thus be replaced."""
        return str(place.resolve()) in self._written

    def begin(self) -> None:
        """Keep from now on what is finished, and which files this run writes.

        Raises:
            InputError: if the place cannot be written to.
        """
        if self.path is not None:
            places = list(dict.fromkeys([*self._written, *self._places]))
            lines = [json_line({**self._made_with, _PLACES: places}), *map(json_line, map(asdict, self.done.values()))]
            write_text(self.path, "".join(lines))

    def __call__(self, trial: FieldTrial) -> None:
        """Add a trial that is finished."""
        if self.path is None:
            return
        try:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json_line(asdict(trial)))
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written ({error.strerror}); choose another place.") from None

    def finish(self) -> None:
        """Nothing is left to go on with."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def _read(self, path: Path) -> None:
        try:
            first, end, lines = path.read_text(encoding="utf-8").partition("\n")
        except (OSError, ValueError):
            raise self._mismatch_error() from None
        if not first.strip() or (not end and first.startswith("{")):
            return  # killed before the first line was whole
        try:
            header = dict(json.loads(first))
        except (ValueError, TypeError):
            raise self._mismatch_error() from None
        written = header.pop(_PLACES, [])
        if header != self._made_with:
            raise self._mismatch_error()
        self._written = [str(place) for place in written]
        for line in lines.splitlines():
            try:
                trial = as_trial(json.loads(line))
            except (ValueError, TypeError, KeyError, AttributeError):  # cut short when it was killed
                continue
            self.done[trial.key] = trial

    def _mismatch_error(self) -> InputError:
        return InputError(
            f"{self.path} belongs to a comparison with other settings or versions; remove it to begin anew, or choose "
            "another file."
        )
