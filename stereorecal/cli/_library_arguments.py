"""Options as the arguments that the library takes, and as the settings in the JSON."""

from collections.abc import Collection
from dataclasses import asdict
from typing import Any

from stereorecal.cli._options import CommonOptions, value_of
from stereorecal.decision import Tolerances
from stereorecal.objectives import Reach
from stereorecal.recalibration import Settings
from stereorecal.strategies import Budget


def library_options(options: CommonOptions, names: Collection[str]) -> dict[str, Any]:
    """Those of the named options of the library that a command has and that were given."""
    given = (name for name in options.__dataclass_fields__ if name in names and getattr(options, name) is not None)
    return {name: value_of(options, name) for name in given}


def settings_as_json(options: CommonOptions, settings: Settings, names: Collection[str]) -> dict[str, Any]:
    """The named settings in the JSON: what was computed with where that is numbers, else the words."""
    used = {name: value for name, value in settings.options.items() if name in names}
    words = {name: getattr(options, name, value) for name, value in used.items()}
    numbers = {name: asdict(value) for name, value in used.items() if isinstance(value, Reach | Budget | Tolerances)}
    return {**words, **numbers, "matcher": {"name": words["matcher"], **asdict(settings.matcher)}}
