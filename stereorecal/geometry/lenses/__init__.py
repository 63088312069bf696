"""Lens models: how directions become image points, and back. One module each."""

from stereorecal._errors import UnsupportedModelError
from stereorecal.geometry.lenses._equidistant import Equidistant
from stereorecal.geometry.lenses._model import LensModel as LensModel
from stereorecal.geometry.lenses._omni import Omni
from stereorecal.geometry.lenses._radial_tangential import RadialTangential
from stereorecal.geometry.lenses._spheres import DoubleSphere, ExtendedUnified

_MODELS: dict[str, LensModel] = {
    model.NAME: model for model in (RadialTangential(), Equidistant(), DoubleSphere(), ExtendedUnified(), Omni())
}
NAMES = tuple(_MODELS)


def lens_model(name: str) -> LensModel:
    """The model of that name.

    Raises:
        UnsupportedModelError: if there is none.
    """
    if name not in _MODELS:
        raise UnsupportedModelError(f"the lens model {name!r} is not supported; give one of {', '.join(NAMES)}.")
    return _MODELS[name]
