"""A coast: open water, cliffs, hills and houses at 30-200 m; rocks, a boat and buoys nearer."""

import numpy as np

from stereorecal.synthetic.objects._boat import boat
from stereorecal.synthetic.objects._nature import cliff
from stereorecal.synthetic.objects._shoreline import shoreline
from stereorecal.synthetic.objects._things import Things
from stereorecal.synthetic.rendering._patch import Patch
from stereorecal.synthetic.rendering._patch_builder import Studio
from stereorecal.synthetic.surroundings._daylight import daylight
from stereorecal.synthetic.surroundings._ground import Stain, mirrored, shade_map
from stereorecal.synthetic.surroundings._sky import make_sky
from stereorecal.synthetic.surroundings._water import make_water
from stereorecal.synthetic.world._rig_motion import BOAT_EYE, RigMotion, attitude
from stereorecal.synthetic.world._world import World


def coast(rng: np.random.Generator) -> World:
    """Draw a coast from `rng`."""
    studio = Studio(rng, daylight(rng), BOAT_EYE)
    patches, stains = shoreline(studio, int(rng.integers(4, 6)), 34.0, 7, rocky=True)
    for part in (_rocks(studio), _afloat(studio)):
        patches, stains = patches + part[0], stains + part[1]
    water = make_water(rng, float(rng.uniform(0.06, 0.09)), 4.0, 0.06, shade_map(stains, (2.0, 7.0)))
    sky = make_sky(rng, float(rng.uniform(0.75, 0.95)), float(rng.uniform(0.3, 0.5)), 0.25)
    return World(tuple(patches), water, sky, 600.0, RigMotion(BOAT_EYE, attitude(rng), 0.02, 0.2))


def _rocks(studio: Studio) -> Things:
    """Two to four rocks that stand out of the water."""
    rng = studio.rng
    patches: list[Patch] = []
    stains: list[Stain] = []
    for _ in range(int(rng.integers(2, 5))):
        z = float(rng.uniform(10.0, 28.0))
        x, width = z * float(rng.uniform(-0.5, 0.5)), float(rng.uniform(2.0, 6.0))
        high = float(rng.uniform(0.6, 2.2))
        a, b = (x - 0.5 * width, z), (x + 0.5 * width, z + float(rng.uniform(-1.0, 1.0)))
        patches.append(studio.wall(a, b, 0.0, high * 1.15, cliff(0.3 * high, high, 0.28), lean=(0.0, 0.5 * high)))
        stains += mirrored(a, b, high, BOAT_EYE, 0.4)
    return patches, stains


def _afloat(studio: Studio) -> Things:
    """A boat and two mooring buoys."""
    rng = studio.rng
    z = float(rng.uniform(14.0, 30.0))
    patches, stains = boat(
        studio,
        (z * float(rng.uniform(-0.4, 0.4)), z),
        float(rng.uniform(5.0, 8.0)),
        float(rng.uniform(-1, 1)),
        True,
    )
    for _ in range(2):
        z = float(rng.uniform(8.0, 16.0))
        spot = np.array([z * float(rng.uniform(-0.45, 0.45)), z])
        patches.append(studio.pole(spot, 0.55, 0.0, 0.6, 0.55))
        stains += mirrored(spot - np.array([0.3, 0.0]), spot + np.array([0.3, 0.0]), 0.6, BOAT_EYE, 0.4)
    return patches, stains
