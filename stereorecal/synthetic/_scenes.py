"""The kinds of scenes, and the world of each.

To add a kind, write a function here that takes a random generator and returns a `World`, and append it to `MAKERS`.
Draw everything from that generator, so that a seed gives the same images again. What several kinds can show stands in
modules of its own: objects (`_buildings`, `_nature`, `_vehicles`), ground and sky (`_ground`, `_sky`), the motion of
the rig (`_world`).
"""

from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise

import numpy as np

from stereorecal._errors import InputError, checked_choice
from stereorecal.synthetic._buildings import boards, corrugated, facade, house, masonry, paving, plain, quay
from stereorecal.synthetic._ground import make_road, make_water, shade_map
from stereorecal.synthetic._nature import cliff, crown, hill, shoreline, tree
from stereorecal.synthetic._patch import Opaque
from stereorecal.synthetic._sky import make_sky
from stereorecal.synthetic._studio import Studio
from stereorecal.synthetic._vehicles import boat, car
from stereorecal.synthetic._world import World, drawn_motion

_BOAT_EYE, _VAN_EYE = 2.5, 2.0  # height [m] of the left camera on a boat and on a van; chosen
_PAVEMENT = 2.6  # width [m] of the pavement between kerb and houses


def coast(rng: np.random.Generator) -> World:
    """Draw a coast from `rng`."""
    studio = Studio(rng, _BOAT_EYE)
    shoreline(studio, int(rng.integers(4, 6)), 34.0, 7, rocky=True)
    _build_rocks(studio)
    _moor_among_buoys(studio)
    water = make_water(rng, rng.uniform(0.06, 0.09), 4.0, 0.06, shade_map(studio.stains, (2.0, 7.0)))
    sky = make_sky(rng, rng.uniform(0.75, 0.95), rng.uniform(0.3, 0.5), 0.25)
    return World(tuple(studio.patches), water, sky, 600.0, _BOAT_EYE, drawn_motion(rng, _BOAT_EYE, 0.02, 0.2))


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


def _moor_among_buoys(studio: Studio) -> None:
    """A boat and two mooring buoys."""
    rng = studio.rng
    z = rng.uniform(14.0, 30.0)
    boat(studio, (z * rng.uniform(-0.4, 0.4), z), rng.uniform(5.0, 8.0), rng.uniform(-1, 1), mast=True)
    for _ in range(2):
        z = rng.uniform(8.0, 16.0)
        spot = np.array([z * rng.uniform(-0.45, 0.45), z])
        studio.pole(spot, 0.55, 0.0, 0.6, 0.55)
        studio.mirror(spot - np.array([0.3, 0.0]), spot + np.array([0.3, 0.0]), 0.6, 0.4)


def open_sea(rng: np.random.Generator) -> World:
    """Draw an open sea from `rng`."""
    studio = Studio(rng, _BOAT_EYE)
    if rng.uniform() < 0.7:
        z = rng.uniform(50.0, 140.0)
        boat(studio, (z * rng.uniform(-0.4, 0.4), z), rng.uniform(7.0, 12.0), rng.uniform(-1, 1), mast=True)
    water = make_water(rng, rng.uniform(0.008, 0.014), 6.0, 0.1, shade_map(studio.stains, (2.0, 5.0)))
    sky = make_sky(rng, rng.uniform(0.8, 0.95), rng.uniform(0.5, 0.6), 0.06)
    return World(tuple(studio.patches), water, sky, 120.0, _BOAT_EYE, drawn_motion(rng, _BOAT_EYE, 0.01, 0.3))


def harbour(rng: np.random.Generator) -> World:
    """Draw a harbour from `rng`."""
    studio = Studio(rng, _BOAT_EYE)
    _build_quay(studio)
    _build_pier(studio)
    _moor(studio)
    shoreline(studio, int(rng.integers(2, 4)), 55.0, 9)
    water = make_water(rng, rng.uniform(0.04, 0.07), 2.5, 0.07, shade_map(studio.stains, (2.0, 7.0)))
    sky = make_sky(rng, rng.uniform(0.75, 0.95), rng.uniform(0.3, 0.5), 0.22)
    return World(tuple(studio.patches), water, sky, 500.0, _BOAT_EYE, drawn_motion(rng, _BOAT_EYE, 0.012, 0.15))


def _build_quay(studio: Studio) -> None:
    """The quay across the view with containers, sheds, crates, trees, bollards and lamp posts on it."""
    rng = studio.rng
    far, slant = rng.uniform(15.0, 26.0), rng.uniform(-0.3, 0.3)
    height = rng.uniform(1.3, 2.0)
    opening = float(rng.choice([-1.0, 1.0]))  # the quay ends on this side, and the coast shows
    end = rng.uniform(0.15, 0.45) * far

    def at(x: float, back: float = 0.0) -> np.ndarray:
        return np.array([x - slant * back, far + slant * x + back])

    low, high = (-1.1 * far, end) if opening > 0 else (-end, 1.1 * far)
    edges = np.linspace(low, high, 4)
    stone = quay(rng.uniform(0.25, 0.4), 0.5)
    for a, b in pairwise(edges):
        studio.wall(at(a), at(b), 0.0, height, stone)
    tip = high if opening > 0 else low
    studio.wall(at(tip), at(tip, 9.0), 0.0, height, stone)
    studio.slab(at(low), at(high), at(low, 9.0) - at(low), height, paving(0.3))
    studio.mirror(at(low), at(high), height + 1.5, 0.4)
    x = low + 1.0
    while x < high - 4.0:
        width = rng.uniform(2.4, 7.0)
        back = rng.uniform(2.5, 6.0)
        middle, turn = at(x + 0.5 * width, back), float(np.arctan(slant))
        draw = rng.uniform()
        if draw < 0.35:
            paint = corrugated(float(rng.choice([0.08, 0.18, 0.3, 0.5])))
            for level in range(int(rng.integers(1, 3))):
                studio.box(middle, (width, 2.5, 2.4), turn, height + 2.5 * level, paint, plain(0.3))
        elif draw < 0.75:
            tall = rng.uniform(3.0, 7.0)
            base = masonry(0.24, 0.24, 0.075) if rng.uniform() < 0.5 else boards(rng.uniform(0.15, 0.5))
            paint = facade(0.4, base=base) if rng.uniform() < 0.8 else base
            a, b = at(x, back - 2.0), at(x + width, back - 2.0)
            house(studio, a, b, 5.0, height, tall, paint, base)
        elif draw < 0.85:
            crate = boards(rng.uniform(0.2, 0.4), 0.14, upright=False)
            for _ in range(3):
                spot = at(x + rng.uniform(0.0, width), rng.uniform(1.0, 4.0))
                studio.box(spot, (1.2, 1.1, 1.1), rng.uniform(-1, 1), height, crate, crate)
        else:
            studio.card(middle, 4.5, height + 1.2, height + 6.0, crown(0.13))
            studio.pole(middle, 0.3, height, height + 2.5, 0.12)
        x += width + rng.uniform(0.3, 2.5)
    for x in np.arange(low + 1.0, high, 3.1):
        studio.pole(at(x, 0.5), 0.28, height, height + 0.5, 0.08)
    for x in rng.uniform(low, high, 3):
        studio.pole(at(x, 1.2), 0.13, height, height + 6.5, 0.3)


def _build_pier(studio: Studio) -> None:
    """A pier on one side that runs towards the camera, with crates on it."""
    rng = studio.rng
    side = float(rng.choice([-1.0, 1.0]))
    near, far, height = rng.uniform(6.5, 9.0), rng.uniform(15.0, 20.0), rng.uniform(0.8, 1.4)
    a = np.array([side * rng.uniform(2.6, 3.8), near])
    b = a + np.array([side * rng.uniform(-0.5, 2.0), far - near])
    out = np.array([side * 4.0, 0.0])
    stone = quay(0.3, 0.35) if rng.uniform() < 0.6 else boards(0.16, 0.25)
    studio.wall(a, b, 0.0, height, stone)
    studio.wall(a, a + out, 0.0, height, stone)
    studio.slab(a, a + out, b - a, height, paving(0.3))
    for part in (0.03, 0.5, 0.97):
        post = a + part * (b - a) - side * np.array([0.15, 0.0])
        studio.pole(post, 0.3, 0.0, height + 0.7, 0.12)
    for part in np.sort(rng.uniform(0.1, 0.95, 3)):
        spot = a + part * (b - a) + rng.uniform(0.3, 0.7) * out
        wide = rng.uniform(0.7, 1.5)
        paint = boards(rng.uniform(0.2, 0.45), 0.14, upright=rng.uniform() < 0.5)
        studio.box(spot, (wide, 0.9, 0.9), rng.uniform(-0.6, 0.6), height, paint, paint)
    studio.mirror(a, b, height, 0.35)
    studio.mirror(a, a + out, height, 0.35)


def _moor(studio: Studio) -> None:
    """Two or three boats at moorings."""
    rng = studio.rng
    slots = rng.permutation([(-0.38, 10.0), (-0.05, 12.5), (0.3, 10.5), (0.12, 14.5)])[: int(rng.integers(2, 4))]
    for slope, distance in slots:
        z = distance + rng.uniform(-0.8, 0.8)
        length = rng.uniform(3.8, 6.5)
        boat(studio, (slope * z, z), length, rng.uniform(-0.7, 0.7), mast=rng.uniform() < 0.6)


def street(rng: np.random.Generator) -> World:
    """Draw a street from `rng`."""
    studio = Studio(rng, _VAN_EYE)
    half, middle = rng.uniform(4.6, 5.6), rng.uniform(0.4, 2.0)
    _build_far_end(studio)
    for side in (-1.0, 1.0):
        _build_houses(studio, side, middle, half)
        _line_kerb(studio, side, middle, half)
    light, shade = studio.light.on(np.array([0.0, 1.0, 0.0])), shade_map(studio.stains, (2.0, 2.0))
    road = make_road(rng, half, middle, light, shade)
    sky = make_sky(rng, rng.uniform(0.85, 1.0), rng.uniform(0.4, 0.55), 0.2)
    return World(tuple(studio.patches), road, sky, 350.0, _VAN_EYE, drawn_motion(rng, _VAN_EYE, 0.004, 0.4))


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


# The position of a kind is part of its seed: append, so that the other kinds keep their images.
MAKERS: dict[str, Callable[[np.random.Generator], World]] = {
    "harbour": harbour,
    "coast": coast,
    "open-sea": open_sea,
    "street": street,
}
"""Name of each kind and what makes a world of it."""

KINDS = tuple(MAKERS)


@lru_cache(maxsize=4)
def make_world(kind: str, seed: int) -> World:
    """The world of a kind drawn from `seed`; the last four are cached, since render and ground truth share them.

    Raises:
        InputError: for an unknown kind or a negative seed.
    """
    checked_choice(kind, KINDS, "kind of scene")
    if seed < 0:
        raise InputError(f"the seed is {seed}; give a whole number that is not negative.")
    return MAKERS[kind](np.random.default_rng([KINDS.index(kind), seed]))
