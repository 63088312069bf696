"""Open sea: calm water in haze, sky, and perhaps a distant boat; almost no texture to match."""

import numpy as np

from stereorecal.synthetic.objects._boat import boat
from stereorecal.synthetic.rendering._patch_builder import Studio
from stereorecal.synthetic.surroundings._daylight import daylight
from stereorecal.synthetic.surroundings._ground import shade_map
from stereorecal.synthetic.surroundings._sky import make_sky
from stereorecal.synthetic.surroundings._water import make_water
from stereorecal.synthetic.world._rig_motion import BOAT_EYE, RigMotion, attitude
from stereorecal.synthetic.world._world import World


def open_sea(rng: np.random.Generator) -> World:
    """Draw an open sea from `rng`."""
    studio = Studio(rng, daylight(rng), BOAT_EYE)
    patches, stains = [], []
    if rng.uniform() < 0.7:
        z = float(rng.uniform(50.0, 140.0))
        x = z * float(rng.uniform(-0.4, 0.4))
        patches, stains = boat(studio, (x, z), float(rng.uniform(7.0, 12.0)), float(rng.uniform(-1, 1)), True)
    water = make_water(rng, float(rng.uniform(0.008, 0.014)), 6.0, 0.1, shade_map(stains, (2.0, 5.0)))
    sky = make_sky(rng, float(rng.uniform(0.8, 0.95)), float(rng.uniform(0.5, 0.6)), 0.06)
    return World(tuple(patches), water, sky, 120.0, RigMotion(BOAT_EYE, attitude(rng), 0.01, 0.3))
