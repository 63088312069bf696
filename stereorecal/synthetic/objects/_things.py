"""What every maker of objects returns."""

from stereorecal.synthetic.rendering._patch import Patch
from stereorecal.synthetic.surroundings._ground import Stain

Things = tuple[list[Patch], list[Stain]]
"""Patches, and where they darken the ground: shadows on a road, reflections in water."""
