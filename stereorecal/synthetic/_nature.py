"""Trees, paints of natural surfaces, and shorelines: hills and cliffs one behind another, with houses on the slopes."""

import numpy as np

from stereorecal.synthetic._buildings import facade, house, plain
from stereorecal.synthetic._noise import Texture, fractal
from stereorecal.synthetic._patch import Canvas, as_paint
from stereorecal.synthetic._studio import Studio


def _relief(height: Texture, strength: float) -> Texture:
    """Shading (h, w) in -1..1 of a height field lit from the upper left."""
    rows, columns = np.gradient(height)
    return np.tanh(strength * (columns + rows))


def _profile(canvas: Canvas, low: float, high: float, scale: float) -> Texture:
    """Heights (1, w) [m] of a skyline between `low` and `high`, tapered to 0 at both ends."""
    line = fractal(canvas.rng, (8, canvas.shape[1]), (64.0, scale / canvas.texel), 8, 0.5)[:1]
    taper = np.clip(np.minimum(canvas.x, canvas.width - canvas.x) / (0.12 * canvas.width), 0.0, 1.0)
    body = low + (high - low) * np.clip(0.5 + 0.45 * line, 0.0, 1.0)
    return body * np.sqrt(taper)


@as_paint
def hill(canvas: Canvas, low: float, high: float, rock: float, scale: float = 60.0) -> tuple[Texture, Texture]:
    """A hillside with woods and meadows, and bare rock at its foot; its skyline lies between `low` and `high` [m].

    Args:
        rock: height [m] of the bare rock.
        scale: width [m] of the largest features of the skyline.
    """
    top = _profile(canvas, low, high, scale)
    bumps = 0.25 * canvas.noise(1.6, 0.9, 6, 0.9)
    mask = np.clip(0.5 + (top + bumps - canvas.y) / (2.0 * canvas.texel), 0.0, 1.0)
    folds = canvas.noise(0.35 * scale, 0.15 * scale, 8, 0.6)
    crowns = canvas.noise(2.6, 1.7, 6, 0.85)
    woods = 0.085 * np.exp(0.55 * crowns + 0.35 * _relief(crowns, 6.0))
    meadow = 0.22 * np.exp(0.2 * canvas.noise(7.0, 1.2, 8, 0.8))
    open_land = np.clip(0.5 + 2.5 * (canvas.noise(16.0, 3.0, 7, 0.7) - 0.3), 0.0, 1.0)
    image = woods + open_land * (meadow - woods)
    image = image * np.exp(0.3 * _relief(folds, 14.0))
    ragged = rock * (1.0 + 0.45 * canvas.noise(9.0, 5.0, 7))
    bare = np.clip(0.5 + (ragged - canvas.y) / 0.6, 0.0, 1.0)
    image = image + bare * (_rock(canvas) - image)
    foot = np.clip(canvas.y / 0.5, 0.25, 1.0)
    return (image * foot).astype(np.float32), mask.astype(np.float32)


@as_paint
def cliff(canvas: Canvas, low: float, high: float, albedo: float = 0.36) -> tuple[Texture, Texture]:
    """A bare cliff with strata, clefts and grass on top; its skyline lies between `low` and `high` [m]."""
    top = _profile(canvas, low, high, 18.0)
    mask = np.clip(0.5 + (top + 0.12 * canvas.noise(1.2) - canvas.y) / (2.0 * canvas.texel), 0.0, 1.0)
    image = _rock(canvas) * (albedo / 0.3)
    cap = np.clip(0.5 + (canvas.y - top + 1.2 + 0.5 * canvas.noise(3.0)) / 0.4, 0.0, 1.0)
    grass = 0.12 * np.exp(0.4 * canvas.noise(1.2, 0.6, 6, 0.9))
    image = image + cap * (grass - image)
    wet = np.clip(1.4 - canvas.y / 0.7 + 0.3 * canvas.noise(2.0), 0.0, 1.0)
    return (image * (1.0 - 0.7 * wet)).astype(np.float32), mask.astype(np.float32)


def _rock(canvas: Canvas) -> Texture:
    """Albedo of bare rock: tilted strata, lumps and dark clefts."""
    tilt = canvas.y + 0.18 * canvas.x + 0.5 * canvas.noise(9.0, 5.0)
    strata = np.sin(6.5 * tilt) + 0.6 * np.sin(15.1 * tilt + 1.0)
    clefts = np.exp(-4.0 * np.abs(canvas.noise(2.4, 5.0, 7, 0.65)))
    lumps = canvas.noise(2.2, 1.8, 8, 0.75)
    image = 0.3 * np.exp(0.09 * strata + 0.25 * lumps + 0.45 * _relief(lumps, 9.0))
    return image * (1.0 - 0.65 * clefts)


@as_paint
def crown(canvas: Canvas, albedo: float) -> tuple[Texture, Texture]:
    """A clump of leaves with ragged edges and holes."""
    across = canvas.x / canvas.width * 2.0 - 1.0
    up = canvas.y / canvas.height * 2.0 - 1.0
    radius = np.sqrt(across**2 + up**2)
    leaves = canvas.noise(0.5, 0.45, 6, 0.95)
    clumps = canvas.noise(0.35 * canvas.width, octaves=4)
    mask = 0.5 + 2.0 * (0.78 - radius) + 0.55 * leaves + 0.45 * clumps
    mask = mask - 12.0 * np.clip(np.maximum(np.abs(across), np.abs(up)) - 0.84, 0.0, 1.0) * (1.0 + 0.5 * leaves)
    lit = 0.75 + 0.35 * up - 0.1 * across
    image = albedo * lit * np.exp(0.4 * leaves + 0.35 * clumps)
    return image.astype(np.float32), np.clip(mask, 0.0, 1.0).astype(np.float32)


def tree(studio: Studio, foot: tuple[float, float], tall: float) -> None:
    """Grow a tree `tall` [m] at ground point `foot`: a trunk, clumps of leaves around it, and its shadow."""
    rng = studio.rng
    studio.pole(foot, 0.28, 0.0, 0.55 * tall, 0.1)
    for _ in range(7):
        away, angle = rng.uniform(0.1, 0.26) * tall, rng.uniform(0.0, 2 * np.pi)
        spot = (foot[0] + away * np.cos(angle), foot[1] + away * np.sin(angle))
        width, low = rng.uniform(0.32, 0.5) * tall, rng.uniform(0.36, 0.68) * tall
        studio.card(spot, width, low, low + 0.85 * width, crown(rng.uniform(0.08, 0.16)))
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    shift = studio.light.sun[[0, 2]] * (-0.6 * tall / studio.light.sun[1])
    circle = np.array(foot) + shift + 0.3 * tall * np.stack([np.cos(angles), np.sin(angles)], -1)
    studio.stain(circle, 0.6)


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
