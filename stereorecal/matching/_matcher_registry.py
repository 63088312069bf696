"""Matchers by name, from the entry-point group `stereorecal.matchers`; each is imported when it is used."""

from dataclasses import replace
from typing import Any

from stereorecal._errors import InputError
from stereorecal._plugins import MATCHER_NAMES, Registry
from stereorecal.matching._matcher import AbstractMatcher, called
from stereorecal.matching.sad import SAD

_REGISTRY: Registry[AbstractMatcher] = replace(MATCHER_NAMES, base=AbstractMatcher)


overview = _REGISTRY.overview
name_of = _REGISTRY.name_of
origin_of = _REGISTRY.origin_of


def matchers() -> tuple[str, ...]:
    """The names of all installed matchers, sorted; imports none of them."""
    return _REGISTRY.names()


def matcher(name: str, /, **options: Any) -> AbstractMatcher:
    """The matcher registered as `name`, with the given options: `sr.matcher("sgbm", num_disparities=128)`.

    Raises:
        InputError: if no such matcher is installed, two distributions claim the name, or an option is unknown or
            refused by the matcher.
        MatcherError: if it cannot be imported, or crashes when it is made.
    """
    return _REGISTRY.make(name, options)


def as_matcher(given: Any) -> AbstractMatcher:
    """The matcher itself, the one of that name with its default options, or `SAD()` for None.

    Raises:
        InputError, MatcherError: as `matcher` does, and if it is neither a name nor a matcher.
    """
    if given is None:
        return SAD()
    if isinstance(given, AbstractMatcher):
        return given
    if isinstance(given, str):
        return matcher(given)
    if isinstance(given, type) and issubclass(given, AbstractMatcher):
        raise InputError(f"matcher is the class {given.__name__}; make one of it, such as {called(given)}().")
    raise InputError(
        f"matcher is a {type(given).__name__}; give a name ({', '.join(matchers())}) or a matcher such as "
        "sr.SGBM(num_disparities=128)."
    )
