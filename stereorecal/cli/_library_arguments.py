"""Options as the arguments that the library takes, and as the settings in the JSON."""

from collections.abc import Collection
from typing import Any

from stereorecal.cli._options import CommonOptions, value_of
from stereorecal.recalibration import Settings, settings_as_data


def library_options(options: CommonOptions, names: Collection[str]) -> dict[str, Any]:
    """Those of the named options of the library that a command has and that were given."""
    given = (name for name in options.__dataclass_fields__ if name in names and getattr(options, name) is not None)
    return {name: value_of(options, name) for name in given}


def settings_as_json(options: CommonOptions, settings: Settings, names: Collection[str]) -> dict[str, Any]:
    """The named settings in the JSON: what was computed with where that is plain data, else the words."""
    data = settings_as_data(settings)
    return {name: data[name] if name in data else getattr(options, name) for name in names}
