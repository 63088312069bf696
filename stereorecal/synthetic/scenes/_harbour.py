"""A harbour: quays with sheds, boxes and boats at 5-40 m, a coast line behind."""

from itertools import pairwise

import numpy as np

from stereorecal.synthetic.objects._boat import boat
from stereorecal.synthetic.objects._house import house
from stereorecal.synthetic.objects._nature import cliff, crown, hill
from stereorecal.synthetic.objects._walls import boards, corrugated, facade, masonry, paving, plain, quay
from stereorecal.synthetic.rendering._patch import Light, Patch
from stereorecal.synthetic.rendering._studio import Studio
from stereorecal.synthetic.scenes._world import World
from stereorecal.synthetic.surroundings._ground import Stain, mirrored, shade_map
from stereorecal.synthetic.surroundings._sky import make_sky
from stereorecal.synthetic.surroundings._water import make_water

EYE = 2.5
"""Height [m] of the left camera on a boat."""


def harbour(rng: np.random.Generator) -> World:
    """A harbour drawn from `rng`."""
    studio = Studio(rng, daylight(rng), EYE)
    patches, stains = _front(studio)
    for part in (_pier(studio), _moored(studio), coast_line(studio, int(rng.integers(2, 4)), 55.0, 9)):
        patches, stains = patches + part[0], stains + part[1]
    water = make_water(rng, float(rng.uniform(0.04, 0.07)), 2.5, 0.07, shade_map(stains, (2.0, 7.0)))
    sky = make_sky(rng, float(rng.uniform(0.75, 0.95)), float(rng.uniform(0.3, 0.5)), 0.22)
    return World(tuple(patches), water, sky, 500.0, EYE, attitude(rng), 0.012, 0.15)


def daylight(rng: np.random.Generator) -> Light:
    """A sun somewhere behind or beside the camera."""
    azimuth, height = rng.uniform(-2.2, 2.2), rng.uniform(0.45, 0.95)
    sun = np.array([np.cos(height) * np.sin(azimuth), np.sin(height), -np.cos(height) * np.cos(azimuth)])
    return Light(sun, float(rng.uniform(0.75, 1.2)), float(rng.uniform(0.28, 0.42)))


def attitude(rng: np.random.Generator) -> tuple[float, float]:
    """Pitch and roll [rad] of a rig at rest: it looks a little downwards."""
    return float(rng.uniform(-0.05, 0.0)), float(rng.uniform(-0.03, 0.03))


def _front(studio: Studio) -> tuple[list[Patch], list[Stain]]:
    """The quay across the view, with what stands on it."""
    rng = studio.rng
    far, slant = float(rng.uniform(15.0, 26.0)), float(rng.uniform(-0.3, 0.3))
    height = float(rng.uniform(1.3, 2.0))
    opening = float(rng.choice([-1.0, 1.0]))  # the quay ends on this side, and the coast shows
    end = float(rng.uniform(0.15, 0.45)) * far

    def at(x: float, back: float = 0.0) -> np.ndarray:
        return np.array([x - slant * back, far + slant * x + back])

    low, high = (-1.1 * far, end) if opening > 0 else (-end, 1.1 * far)
    edges = np.linspace(low, high, 4)
    stone = quay(float(rng.uniform(0.25, 0.4)), 0.5)
    patches = [studio.wall(at(a), at(b), 0.0, height, stone) for a, b in pairwise(edges)]
    tip = high if opening > 0 else low
    patches.append(studio.wall(at(tip), at(tip, 9.0), 0.0, height, stone))
    patches.append(studio.slab(at(low), at(high), at(low, 9.0) - at(low), height, paving(0.3)))
    stains = mirrored(at(low), at(high), height + 1.5, EYE, 0.4)
    x = low + 1.0
    while x < high - 4.0:
        width = float(rng.uniform(2.4, 7.0))
        back = float(rng.uniform(2.5, 6.0))
        centre, turn = at(x + 0.5 * width, back), float(np.arctan(slant))
        middle = (centre[0], centre[1])
        draw = rng.uniform()
        if draw < 0.35:
            paint = corrugated(float(rng.choice([0.08, 0.18, 0.3, 0.5])))
            for level in range(int(rng.integers(1, 3))):
                patches += studio.box(middle, (width, 2.5, 2.4), turn, height + 2.5 * level, paint, plain(0.3))
        elif draw < 0.75:
            tall = float(rng.uniform(3.0, 7.0))
            base = masonry(0.24, 0.24, 0.075) if rng.uniform() < 0.5 else boards(float(rng.uniform(0.15, 0.5)))
            paint = facade(0.4, base=base) if rng.uniform() < 0.8 else base
            a, b = at(x, back - 2.0), at(x + width, back - 2.0)
            patches += house(studio, a, b, 5.0, height, tall, paint, base)
        elif draw < 0.85:
            crate = boards(float(rng.uniform(0.2, 0.4)), 0.14, upright=False)
            for _ in range(3):
                spot = at(x + float(rng.uniform(0.0, width)), float(rng.uniform(1.0, 4.0)))
                patches += studio.box(
                    (spot[0], spot[1]), (1.2, 1.1, 1.1), float(rng.uniform(-1, 1)), height, crate, crate
                )
        else:
            patches.append(studio.card(middle, 4.5, height + 1.2, height + 6.0, crown(0.13)))
            patches.append(studio.pole(middle, 0.3, height, height + 2.5, 0.12))
        x += width + float(rng.uniform(0.3, 2.5))
    for x in np.arange(low + 1.0, high, 3.1):
        patches.append(studio.pole(at(x, 0.5), 0.28, height, height + 0.5, 0.08))
    for x in rng.uniform(low, high, 3):
        patches.append(studio.pole(at(x, 1.2), 0.13, height, height + 6.5, 0.3))
    return patches, stains


def _pier(studio: Studio) -> tuple[list[Patch], list[Stain]]:
    """A pier that comes towards the camera on one side, with boxes on it."""
    rng = studio.rng
    side = float(rng.choice([-1.0, 1.0]))
    near, far, height = (
        float(rng.uniform(6.5, 9.0)),
        float(rng.uniform(15.0, 20.0)),
        float(rng.uniform(0.8, 1.4)),
    )
    a = np.array([side * float(rng.uniform(2.6, 3.8)), near])
    b = a + np.array([side * float(rng.uniform(-0.5, 2.0)), far - near])
    out = np.array([side * 4.0, 0.0])
    stone = quay(0.3, 0.35) if rng.uniform() < 0.6 else boards(0.16, 0.25)
    patches = [
        studio.wall(a, b, 0.0, height, stone),
        studio.wall(a, a + out, 0.0, height, stone),
        studio.slab(a, a + out, b - a, height, paving(0.3)),
    ]
    for part in (0.03, 0.5, 0.97):
        post = a + part * (b - a) - side * np.array([0.15, 0.0])
        patches.append(studio.pole(post, 0.3, 0.0, height + 0.7, 0.12))
    for part in np.sort(rng.uniform(0.1, 0.95, 3)):
        spot = a + part * (b - a) + float(rng.uniform(0.3, 0.7)) * out
        wide = float(rng.uniform(0.7, 1.5))
        paint = boards(float(rng.uniform(0.2, 0.45)), 0.14, upright=bool(rng.uniform() < 0.5))
        patches += studio.box((spot[0], spot[1]), (wide, 0.9, 0.9), float(rng.uniform(-0.6, 0.6)), height, paint, paint)
    return patches, [*mirrored(a, b, height, EYE, 0.35), *mirrored(a, a + out, height, EYE, 0.35)]


def _moored(studio: Studio) -> tuple[list[Patch], list[Stain]]:
    rng = studio.rng
    patches: list[Patch] = []
    stains: list[Stain] = []
    slots = rng.permutation([(-0.38, 10.0), (-0.05, 12.5), (0.3, 10.5), (0.12, 14.5)])[: int(rng.integers(2, 4))]
    for slope, distance in slots:
        z = distance + float(rng.uniform(-0.8, 0.8))
        length = float(rng.uniform(3.8, 6.5))
        more, dark = boat(studio, (slope * z, z), length, float(rng.uniform(-0.7, 0.7)), bool(rng.uniform() < 0.6))
        patches, stains = patches + more, stains + dark
    return patches, stains


def coast_line(
    studio: Studio, count: int, nearest: float, houses: int, rocky: bool = False
) -> tuple[list[Patch], list[Stain]]:
    """`count` hills or cliffs from `nearest` metres to 200 m, then a far ridge in the haze."""
    rng = studio.rng
    patches: list[Patch] = []
    stains: list[Stain] = []
    for distance in np.geomspace(nearest, 200.0, count):
        z = float(distance * rng.uniform(0.9, 1.1))
        width = z * float(rng.uniform(1.0, 1.7))
        middle = z * float(rng.uniform(-0.5, 0.5))
        turn = z * float(rng.uniform(-0.3, 0.3))
        high = z * float(rng.uniform(0.09, 0.17)) + 2.0
        a, b = (middle - 0.5 * width, z - 0.5 * turn), (middle + 0.5 * width, z + 0.5 * turn)
        line = np.array(b) - np.array(a)
        away = np.array([-line[1], line[0]]) / np.linalg.norm(line)
        if rocky and rng.uniform() < 0.6:
            paint, slope = cliff(0.4 * high, high), 0.15
        else:
            paint, slope = hill(0.35 * high, high, 0.08 * high, 0.5 * z), 0.9
            few = houses if z > 60.0 else min(houses, 2)
            patches += _village(studio, np.array(a), line, away, slope, few, 0.35 * high)
        lean = slope * 1.1 * high * away
        patches.append(studio.wall(a, b, 0.0, high * 1.1, paint, lean=(lean[0], lean[1])))
        stains += mirrored(a, b, 0.5 * high, studio.eye, 0.6)
    ridge = hill(10.0, 40.0, 0.0, 200.0)
    patches.append(studio.wall((-700.0, 620.0), (700.0, 620.0), 0.0, 60.0, ridge, lean=(0.0, 50.0)))
    return patches, stains


def _village(studio: Studio, start, line, away, slope: float, count: int, high: float) -> list[Patch]:
    """Houses on a hillside that rises from the ground line `line` at `start`, up to `high` metres."""
    rng = studio.rng
    patches: list[Patch] = []
    along = line / np.linalg.norm(line)
    for part in 0.1 + 0.75 * (np.arange(count) + rng.uniform(0.0, 0.6, count)) / count:
        low = float(rng.uniform(0.15, 0.75)) * high
        width, tall = float(rng.uniform(5.0, 10.0)), float(rng.choice([2.8, 3.0, 5.5]))
        a = start + part * line + slope * low * away
        albedo = float(rng.uniform(0.3, 0.75))
        front = facade(albedo, 2.7)
        patches += house(studio, a, a + width * along, 6.0, low - 0.3, tall, front, plain(albedo))
    return patches
