"""World: the content of a scene, which is solid patches, ground, sky, haze, and the motion of the rig."""

from dataclasses import dataclass

from stereorecal.synthetic.rendering._patch import Patch
from stereorecal.synthetic.surroundings._road import Road
from stereorecal.synthetic.surroundings._sky import Sky
from stereorecal.synthetic.surroundings._water import Water
from stereorecal.synthetic.world._motion import RigMotion


@dataclass(frozen=True, eq=False)
class World:
    """Everything that a rendered scene shows.

    Attributes:
        patches: the solid objects.
        ground: the surface at y = 0.
        sky: the sky.
        haze: distance [m] over which haze reduces contrast to 1/e.
        motion: pose of the rig in each frame.
    """

    patches: tuple[Patch, ...]
    ground: Water | Road
    sky: Sky
    haze: float
    motion: RigMotion
