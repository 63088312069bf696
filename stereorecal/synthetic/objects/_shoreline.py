"""Shorelines: hills and cliffs one behind another, with houses on the slopes."""

import numpy as np

from stereorecal.synthetic.objects._building_paints import facade, plain
from stereorecal.synthetic.objects._house import house
from stereorecal.synthetic.objects._nature import cliff, hill
from stereorecal.synthetic.objects._studio import Studio


def shoreline(studio: Studio, count: int, nearest: float, houses: int, rocky: bool = False) -> None:
    """Raise `count` hills, some cliffs among them if `rocky`, from `nearest` to 200 m away, and a far ridge in haze.

    `houses` stand on each far hill, at most two on those within 60 m.
    """
    rng = studio.rng
    for distance in np.geomspace(nearest, 200.0, count):
        z = float(distance * rng.uniform(0.9, 1.1))
        width = z * rng.uniform(1.0, 1.7)
        middle = z * rng.uniform(-0.5, 0.5)
        turn = z * rng.uniform(-0.3, 0.3)
        high = z * rng.uniform(0.09, 0.17) + 2.0
        a, b = np.array([[middle - 0.5 * width, z - 0.5 * turn], [middle + 0.5 * width, z + 0.5 * turn]])
        line = b - a
        away = np.array([-line[1], line[0]]) / np.linalg.norm(line)
        if rocky and rng.uniform() < 0.6:
            paint, slope = cliff(0.4 * high, high), 0.15
        else:
            paint, slope = hill(0.35 * high, high, 0.08 * high, 0.5 * z), 0.9
            few = houses if z > 60.0 else min(houses, 2)
            _build_village(studio, a, line, away, slope, few, 0.35 * high)
        studio.wall(a, b, 0.0, high * 1.1, paint, lean=slope * 1.1 * high * away)
        studio.mirror(a, b, 0.5 * high, 0.6)
    ridge = hill(10.0, 40.0, 0.0, 200.0)
    studio.wall((-700.0, 620.0), (700.0, 620.0), 0.0, 60.0, ridge, lean=(0.0, 50.0))


def _build_village(studio: Studio, start, line, away, slope: float, count: int, high: float) -> None:
    """`count` houses up to a height of `high` [m] on a hillside that rises from the ground line `line` at `start`.

    `away` is the horizontal unit vector uphill; `slope` is the horizontal distance covered per metre of height.
    """
    rng = studio.rng
    along = line / np.linalg.norm(line)
    for part in 0.1 + 0.75 * (np.arange(count) + rng.uniform(0.0, 0.6, count)) / count:
        low = rng.uniform(0.15, 0.75) * high
        width, tall = rng.uniform(5.0, 10.0), float(rng.choice([2.8, 3.0, 5.5]))
        a = start + part * line + slope * low * away
        albedo = rng.uniform(0.3, 0.75)
        house(studio, a, a + width * along, 6.0, low - 0.3, tall, facade(albedo, 2.7), plain(albedo))
