"""A coast: open water, cliffs, hills and houses at 30-200 m; rocks, a boat and buoys nearer."""

import numpy as np

from stereorecal.synthetic.objects._boat import boat
from stereorecal.synthetic.objects._nature import cliff
from stereorecal.synthetic.objects._shoreline import shoreline
from stereorecal.synthetic.objects._studio import Studio
from stereorecal.synthetic.surroundings._ground import shade_map
from stereorecal.synthetic.surroundings._sky import make_sky
from stereorecal.synthetic.surroundings._water import make_water
from stereorecal.synthetic.world._motion import BOAT_EYE, drawn_motion
from stereorecal.synthetic.world._world import World


def coast(rng: np.random.Generator) -> World:
    """Draw a coast from `rng`."""
    studio = Studio(rng, BOAT_EYE)
    shoreline(studio, int(rng.integers(4, 6)), 34.0, 7, rocky=True)
    _build_rocks(studio)
    _moor(studio)
    water = make_water(rng, rng.uniform(0.06, 0.09), 4.0, 0.06, shade_map(studio.stains, (2.0, 7.0)))
    sky = make_sky(rng, rng.uniform(0.75, 0.95), rng.uniform(0.3, 0.5), 0.25)
    return World(tuple(studio.patches), water, sky, 600.0, drawn_motion(rng, BOAT_EYE, 0.02, 0.2))


def _build_rocks(studio: Studio) -> None:
    """Two to four rocks that stand out of the water."""
    rng = studio.rng
    for _ in range(int(rng.integers(2, 5))):
        z = rng.uniform(10.0, 28.0)
        x, width = z * rng.uniform(-0.5, 0.5), rng.uniform(2.0, 6.0)
        high = rng.uniform(0.6, 2.2)
        a, b = (x - 0.5 * width, z), (x + 0.5 * width, z + rng.uniform(-1.0, 1.0))
        studio.wall(a, b, 0.0, high * 1.15, cliff(0.3 * high, high, 0.28), lean=(0.0, 0.5 * high))
        studio.mirror(a, b, high, 0.4)


def _moor(studio: Studio) -> None:
    """A boat and two mooring buoys."""
    rng = studio.rng
    z = rng.uniform(14.0, 30.0)
    boat(studio, (z * rng.uniform(-0.4, 0.4), z), rng.uniform(5.0, 8.0), rng.uniform(-1, 1), mast=True)
    for _ in range(2):
        z = rng.uniform(8.0, 16.0)
        spot = np.array([z * rng.uniform(-0.45, 0.45), z])
        studio.pole(spot, 0.55, 0.0, 0.6, 0.55)
        studio.mirror(spot - np.array([0.3, 0.0]), spot + np.array([0.3, 0.0]), 0.6, 0.4)
