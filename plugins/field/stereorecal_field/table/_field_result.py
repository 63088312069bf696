"""The table, and its JSON form (`stereorecal.field/1`)."""

import os
from dataclasses import dataclass
from typing import Any

from stereorecal.cli import extra
from stereorecal.io import json_data, write_json, write_text
from stereorecal_field.table._field_summary import FieldSummary, summarised
from stereorecal_field.table._field_trial import FieldTrial

SCHEMA = "stereorecal.field/1"


@dataclass(frozen=True)
class Field:
    """Methods x judged cases.

    Attributes:
        settings: the arguments.
        versions: of Python, stereorecal and what it depends on.
        judges: what each judges by, by name.
        methods: name, what each may change, and where it comes from.
        trials: the finished ones, in the order in which they were planned.
        planned: how many there are to be.
    """

    settings: dict[str, Any]
    versions: dict[str, str]
    judges: dict[str, str]
    methods: tuple[dict[str, str], ...]
    trials: tuple[FieldTrial, ...]
    planned: int

    @property
    def interrupted(self) -> bool:
        """Whether trials are missing."""
        return len(self.trials) < self.planned

    @property
    def summary(self) -> tuple[FieldSummary, ...]:
        """A row for each judge and method."""
        return summarised(self.trials)

    def as_dict(self) -> dict[str, Any]:
        """The content of the JSON file; a missing or non-finite number is None."""
        return json_data(
            {
                "schema": SCHEMA,
                "versions": self.versions,
                "settings": self.settings,
                "interrupted": self.interrupted,
                "planned": self.planned,
                "judges": self.judges,
                "methods": list(self.methods),
                "trials": self.trials,
                "summary": self.summary,
            }
        )

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write the JSON file, whole or not at all."""
        write_json(path, self.as_dict())

    def to_html(self, path: str | os.PathLike[str], *, overwrite: bool = True) -> None:
        """Write one HTML page that needs nothing else, whole or not at all.

        Raises:
            InputError: if jinja2 or matplotlib is not installed, a file exists that must stay, or the place cannot be
                written to.
        """
        with extra("figures", "an HTML page"):
            from stereorecal_field.table._field_page import field_page
        write_text(path, field_page(self.as_dict()), replace=overwrite)
