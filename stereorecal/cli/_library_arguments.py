"""Options as the arguments that the library takes, and as the settings in the JSON."""

from collections.abc import Collection, Sequence
from typing import Any

from stereorecal._version import versions
from stereorecal.cli._options import CommonOptions, value_of
from stereorecal.recalibration import Settings, settings_as_data


def library_options(options: CommonOptions, names: Collection[str]) -> dict[str, Any]:
    """Those of the named options of the library that a command has and that were given."""
    given = (name for name in options.__dataclass_fields__ if name in names and getattr(options, name) is not None)
    return {name: value_of(options, name) for name in given}


def settings_as_json(options: CommonOptions, settings: Settings, names: Sequence[str]) -> dict[str, Any]:
    """The named settings in the JSON, in this order: what was computed with where that is plain data, else the
    words."""
    data = settings_as_data(settings)
    return {name: data[name] if name in data else getattr(options, name) for name in names}


def run_as_json(schema: str, settings: dict[str, Any], *, interrupted: bool, **rows: list[Any]) -> dict[str, Any]:
    """The JSON of a run, with its rows."""
    return {"schema": schema, "versions": versions(), "settings": settings, "interrupted": interrupted, **rows}
