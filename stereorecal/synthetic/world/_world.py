"""A world: solid patches, what covers the ground, the sky, the haze, and how the rig travels through it."""

from dataclasses import dataclass

from stereorecal.synthetic.rendering._patch import Patch
from stereorecal.synthetic.surroundings._road import Road
from stereorecal.synthetic.surroundings._sky import Sky
from stereorecal.synthetic.surroundings._water import Water
from stereorecal.synthetic.world._motion import Motion


@dataclass(frozen=True, eq=False)
class World:
    """Everything there is to see.

    Attributes:
        patches: the solid things.
        ground: what covers y = 0.
        sky: the sky.
        haze: distance [m] at which haze hides all but 1/e of the contrast.
        motion: how the rig moves.
    """

    patches: tuple[Patch, ...]
    ground: Water | Road
    sky: Sky
    haze: float
    motion: Motion
