"""Lens models by name."""

from stereorecal._errors import UnsupportedModelError
from stereorecal.geometry.lenses import _double_sphere, _equidistant, _extended_unified, _omni, _radial_tangential
from stereorecal.geometry.lenses._model import LensModel

_EVERY: tuple[LensModel, ...] = (_radial_tangential, _equidistant, _double_sphere, _extended_unified, _omni)
_MODELS = {model.NAME: model for model in _EVERY}
NAMES = tuple(_MODELS)


def lens_model(name: str) -> LensModel:
    """The model of that name.

    Raises:
        UnsupportedModelError: if there is none.
    """
    if name not in _MODELS:
        raise UnsupportedModelError(f"the lens model {name!r} is not supported; give one of {', '.join(NAMES)}.")
    return _MODELS[name]
