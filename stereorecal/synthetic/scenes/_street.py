"""A street: a road with markings, houses on both sides, parked cars, trees or lamp posts."""

import numpy as np

from stereorecal.synthetic.objects._building_paints import facade, masonry, plain
from stereorecal.synthetic.objects._car import car
from stereorecal.synthetic.objects._house import house
from stereorecal.synthetic.objects._nature import hill, tree
from stereorecal.synthetic.objects._studio import Studio
from stereorecal.synthetic.rendering._patch import Opaque
from stereorecal.synthetic.surroundings._ground import shade_map
from stereorecal.synthetic.surroundings._road import make_road
from stereorecal.synthetic.surroundings._sky import make_sky
from stereorecal.synthetic.world._motion import VAN_EYE, drawn_motion
from stereorecal.synthetic.world._world import World

_PAVEMENT = 2.6  # width [m] of the pavement between kerb and houses


def street(rng: np.random.Generator) -> World:
    """Draw a street from `rng`."""
    studio = Studio(rng, VAN_EYE)
    half, middle = rng.uniform(4.6, 5.6), rng.uniform(0.4, 2.0)
    _build_far_end(studio)
    for side in (-1.0, 1.0):
        _build_houses(studio, side, middle, half)
        _line_kerb(studio, side, middle, half)
    light, shade = studio.light.on(np.array([0.0, 1.0, 0.0])), shade_map(studio.stains, (2.0, 2.0))
    road = make_road(rng, half, middle, light, shade)
    sky = make_sky(rng, rng.uniform(0.85, 1.0), rng.uniform(0.4, 0.55), 0.2)
    return World(tuple(studio.patches), road, sky, 350.0, drawn_motion(rng, VAN_EYE, 0.004, 0.4))


def _front(rng: np.random.Generator) -> Opaque:
    """The front of a house, of plaster or of brick."""
    albedo = rng.uniform(0.25, 0.6)
    brick = masonry(rng.uniform(0.16, 0.3), 0.24, 0.075) if rng.uniform() < 0.5 else None
    return facade(albedo, rng.uniform(2.7, 3.2), brick)


def _build_houses(studio: Studio, side: float, middle: float, half: float) -> None:
    """The row of houses on one side (-1 left, 1 right) of a road `half` wide [m] to either side of x = `middle`."""
    rng = studio.rng
    z = rng.uniform(3.0, 6.0)
    while z < 75.0:
        width, tall = rng.uniform(7.0, 13.0), float(rng.choice([3.2, 5.9, 6.1, 8.8]))
        setback = rng.uniform(0.0, 1.5) + (4.0 if rng.uniform() < 0.2 else 0.0)
        x = middle + side * (half + _PAVEMENT + setback)
        a, b = np.array([x, z]), np.array([x, z + width])
        inwards = np.array([side * 9.0, 0.0])
        brick = masonry(rng.uniform(0.15, 0.3), 0.24, 0.075)
        house(studio, a, b, 8.0, 0.0, tall, _front(rng), brick)
        studio.stain(np.array([a - inwards * 0.06, b - inwards * 0.06, b, a]), 0.75)
        sun = studio.light.sun
        if side * sun[0] > 0.1:  # the house stands between the sun and the street
            reach = np.array([sun[0], sun[2]]) * (-tall / sun[1])
            studio.stain(np.array([a, b, b + reach, a + reach]), 0.55)
        z += width + (rng.uniform(1.5, 4.0) if rng.uniform() < 0.4 else 0.0)


def _line_kerb(studio: Studio, side: float, middle: float, half: float) -> None:
    """Parked cars, and trees or lamp posts, along one kerb."""
    rng = studio.rng
    z = rng.uniform(8.0, 13.0)
    while z < 60.0:
        if rng.uniform() < 0.7:
            car(studio, (middle + side * (half - 1.1 + rng.uniform(-0.1, 0.1)), z), (0.0, side))
        z += rng.uniform(6.0, 9.0)
    trees = rng.uniform() < 0.7
    for z in np.arange(rng.uniform(9.0, 14.0), 60.0, rng.uniform(9.0, 14.0)):
        foot = (middle + side * (half + 0.7), float(z))
        if trees:
            tree(studio, foot, rng.uniform(5.0, 8.0))
        else:
            studio.pole(foot, 0.14, 0.0, 6.5, 0.25)
            studio.wall((foot[0] - side * 1.4, foot[1]), foot, 6.4, 6.5, plain(0.3))


def _build_far_end(studio: Studio) -> None:
    """The far end of the view: houses across the street and a wood behind them."""
    rng = studio.rng
    for x in (-22.0, -10.0, 2.0, 14.0):
        tall = rng.uniform(5.0, 9.0)
        z = 82.0 + rng.uniform(0.0, 6.0)
        house(studio, (x, z), (x + 11.5, z), 8.0, 0.0, tall, _front(rng), plain(0.3))
    wood = hill(9.0, 16.0, 0.0, 40.0)
    studio.wall((-90.0, 120.0), (90.0, 120.0), 0.0, 20.0, wood, lean=(0.0, 10.0))
