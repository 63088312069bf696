"""A harbour: a quay with sheds and containers, a pier and boats at 5-40 m, hills behind."""

from itertools import pairwise

import numpy as np

from stereorecal.synthetic.objects._boat import boat
from stereorecal.synthetic.objects._building_paints import boards, corrugated, facade, masonry, paving, plain, quay
from stereorecal.synthetic.objects._house import house
from stereorecal.synthetic.objects._nature import crown
from stereorecal.synthetic.objects._shoreline import shoreline
from stereorecal.synthetic.objects._studio import Studio
from stereorecal.synthetic.surroundings._ground import shade_map
from stereorecal.synthetic.surroundings._sky import make_sky
from stereorecal.synthetic.surroundings._water import make_water
from stereorecal.synthetic.world._motion import BOAT_EYE, drawn_motion
from stereorecal.synthetic.world._world import World


def harbour(rng: np.random.Generator) -> World:
    """Draw a harbour from `rng`."""
    studio = Studio(rng, BOAT_EYE)
    _build_quay(studio)
    _build_pier(studio)
    _moor(studio)
    shoreline(studio, int(rng.integers(2, 4)), 55.0, 9)
    water = make_water(rng, rng.uniform(0.04, 0.07), 2.5, 0.07, shade_map(studio.stains, (2.0, 7.0)))
    sky = make_sky(rng, rng.uniform(0.75, 0.95), rng.uniform(0.3, 0.5), 0.22)
    return World(tuple(studio.patches), water, sky, 500.0, drawn_motion(rng, BOAT_EYE, 0.012, 0.15))


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
