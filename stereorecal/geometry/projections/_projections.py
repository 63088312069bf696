"""Projections by name."""

from stereorecal._errors import InputError
from stereorecal.geometry.projections import _equirectangular, _pinhole
from stereorecal.geometry.projections._projection import Projection

_EVERY: tuple[Projection, ...] = (_pinhole, _equirectangular)
_PROJECTIONS = {one.NAME: one for one in _EVERY}
NAMES = tuple(_PROJECTIONS)


def projection(name: str) -> Projection:
    """The projection of that name.

    Raises:
        InputError: if there is none.
    """
    if name not in _PROJECTIONS:
        raise InputError(f"there is no projection {name!r}; give one of {', '.join(NAMES)}.")
    return _PROJECTIONS[name]
