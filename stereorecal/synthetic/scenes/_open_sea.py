"""Open sea: calm water in haze, sky, and perhaps a distant boat; almost no texture to match."""

import numpy as np

from stereorecal.synthetic.objects._boat import boat
from stereorecal.synthetic.objects._studio import Studio
from stereorecal.synthetic.surroundings._ground import shade_map
from stereorecal.synthetic.surroundings._sky import make_sky
from stereorecal.synthetic.surroundings._water import make_water
from stereorecal.synthetic.world._motion import BOAT_EYE, drawn_motion
from stereorecal.synthetic.world._world import World


def open_sea(rng: np.random.Generator) -> World:
    """Draw an open sea from `rng`."""
    studio = Studio(rng, BOAT_EYE)
    if rng.uniform() < 0.7:
        z = rng.uniform(50.0, 140.0)
        boat(studio, (z * rng.uniform(-0.4, 0.4), z), rng.uniform(7.0, 12.0), rng.uniform(-1, 1), mast=True)
    water = make_water(rng, rng.uniform(0.008, 0.014), 6.0, 0.1, shade_map(studio.stains, (2.0, 5.0)))
    sky = make_sky(rng, rng.uniform(0.8, 0.95), rng.uniform(0.5, 0.6), 0.06)
    return World(tuple(studio.patches), water, sky, 120.0, drawn_motion(rng, BOAT_EYE, 0.01, 0.3))
