"""Finished trials on the disk, a line each: who is killed goes on where it was."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.comparison.field import FieldTrial, as_trial
from stereorecal.io import json_line

_SUFFIX = ".trials"


class TrialJournal:
    """Beside the first file that a comparison writes, while it is not finished; without one, nothing is kept.

    Attributes:
        path: of the file; None without one.
        done: the trials that an earlier run finished, by key.
        begun: whether there was such a run: the files beside it are this comparison's own.
    """

    def __init__(self, beside: str | Path | None, made_with: Mapping[str, Any]) -> None:
        self.path = None if beside is None else Path(f"{beside}{_SUFFIX}")
        self._header = json_line(made_with)
        self._separator = ""  # after a line that was cut short
        self.done: dict[str, FieldTrial] = {}
        self.begun = self.path is not None and self.path.exists()
        if self.begun:
            self._read()

    def __call__(self, trial: FieldTrial) -> None:
        """Add a trial that is finished."""
        if self.path is None:
            return
        try:
            with self.path.open("a", encoding="utf-8") as file:
                if file.tell() == 0:
                    file.write(self._header)
                file.write(self._separator + json_line(asdict(trial)))
                self._separator = ""
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written ({error.strerror}); choose another place.") from None

    def finish(self) -> None:
        """Nothing is left to go on with."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def _read(self) -> None:
        assert self.path is not None
        try:
            text = self.path.read_text(encoding="utf-8")
        except (OSError, ValueError):
            text = ""
        header, *lines = text.splitlines() or [""]
        same = header == self._header.rstrip("\n")
        self._separator = "" if text.endswith("\n") else "\n"
        if not same:
            raise InputError(
                f"{self.path}: is of a comparison with other settings or versions; remove it to begin anew, or choose "
                "another file."
            )
        for line in lines:
            try:
                trial = as_trial(json.loads(line))
            except (ValueError, TypeError, KeyError):  # cut short when it was killed
                continue
            self.done[trial.key] = trial
