"""Lens models: how directions become image points, and back. One module each."""

from stereorecal.geometry.lenses._model import LensModel as LensModel
from stereorecal.geometry.lenses._models import NAMES as NAMES, lens_model as lens_model
