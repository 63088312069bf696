"""What makers of objects return."""

from stereorecal.synthetic.rendering._patch import Patch
from stereorecal.synthetic.surroundings._ground import Stain

Things = tuple[list[Patch], list[Stain]]
"""The patches of an object, and where it darkens the ground: shadows on a road, reflections in water."""
