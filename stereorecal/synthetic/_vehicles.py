"""Boats, and parked cars and vans: extruded profiles."""

from typing import NamedTuple

import numpy as np

from stereorecal.synthetic._buildings import plain, weathered
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Canvas, as_paint
from stereorecal.synthetic._studio import Ground, Studio, footprint


def boat(studio: Studio, middle: Ground, length: float, turn: float, mast: bool) -> None:
    """Build a boat of `length` [m], its keel along `turn` [rad] (0: along x), with a wheelhouse and perhaps a mast."""
    rng, middle = studio.rng, np.array(middle)
    beam, freeboard = 0.3 * length, 0.11 * length + 0.35
    along, side = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    stern, waist, bow = (middle + part * length * along for part in (-0.5, 0.2, 0.5))
    albedo = float(rng.choice([0.08, 0.2, 0.55, 0.75]))
    hull = _hull(albedo, freeboard)
    for sign in (-1.0, 1.0):
        edge = 0.5 * sign * beam * side
        studio.wall(stern + 0.9 * edge, waist + edge, 0.0, freeboard, hull, lean=0.06 * edge)
        studio.wall(waist + edge, bow, 0.0, freeboard * 1.18, _bow(albedo, freeboard), lean=0.06 * edge)
    corners = stern - 0.45 * beam * side, stern + 0.45 * beam * side
    studio.wall(*corners, 0.0, freeboard, hull)
    studio.slab(*corners, 0.72 * length * along, freeboard - 0.12, plain(0.45, 0.2))
    cabin = middle + rng.uniform(-0.12, 0.05) * length * along
    tall, long = rng.uniform(0.9, 1.5), rng.uniform(0.25, 0.4) * length
    studio.box(cabin, (long, tall, 0.62 * beam), turn, freeboard - 0.1, _cabin(), plain(0.7, 0.15))
    if mast:
        post = cabin + 0.1 * length * along
        studio.pole(post, 0.11, freeboard, freeboard + 1.1 * length, 0.55)
        studio.wall(post - 0.42 * length * along, post, freeboard + 1.5, freeboard + 1.78, _sail())
    studio.pole(stern + 0.1 * along, 0.06, freeboard, freeboard + 1.0, 0.6)
    studio.mirror(stern, bow, freeboard + 0.6, 0.35)
    studio.stain(footprint(middle, length + 0.5, beam + 0.7, turn), 0.5)


@as_paint
def _hull(canvas: Canvas, albedo: float, freeboard: float) -> Texture:
    """The side of a hull: waterline, sheer stripe, fenders or lettering."""
    image = np.full(canvas.shape, albedo, np.float32)
    image = image * (0.75 + 0.35 * canvas.y / canvas.height)
    canvas.fill(image, 0.0, canvas.width, 0.0, 0.14, 0.06)
    canvas.fill(image, 0.0, canvas.width, 0.14, 0.2, 0.5)
    canvas.fill(image, 0.0, canvas.width, freeboard - 0.16, freeboard - 0.07, 0.12 if albedo > 0.3 else 0.6)
    for x in np.arange(0.7, canvas.width - 0.4, canvas.rng.uniform(0.9, 1.7)):
        canvas.fill(image, x, x + 0.2, 0.25 * freeboard, 0.75 * freeboard, canvas.rng.uniform(0.1, 0.8))
    return weathered(canvas, image, 1.1)


@as_paint
def _bow(canvas: Canvas, albedo: float, freeboard: float) -> tuple[Texture, Texture]:
    """The bow of a hull: the stem rakes forward and the sheer rises."""
    u = canvas.x / canvas.width
    stem = canvas.x < canvas.width - 0.35 * (1.0 - canvas.y / canvas.height)
    sheer = canvas.y < freeboard * (1.0 + 0.18 * u**2)
    return _hull(albedo, freeboard)(canvas), (stem & sheer).astype(np.float32)


@as_paint
def _cabin(canvas: Canvas) -> Texture:
    """A wheelhouse with a row of windows."""
    image = np.full(canvas.shape, canvas.rng.uniform(0.5, 0.8), np.float32)
    step = canvas.rng.uniform(0.5, 0.8)
    for x in np.arange(0.14, canvas.width - 0.3, step):
        canvas.fill(image, x, x + step - 0.14, 0.5 * canvas.height, 0.86 * canvas.height, 0.05)
        canvas.fill(image, x, x + 0.4 * step, 0.7 * canvas.height, 0.86 * canvas.height, 0.12)
    return weathered(canvas, image, 0.9)


@as_paint
def _sail(canvas: Canvas) -> Texture:
    """A furled sail on its boom."""
    return 0.5 * np.exp(0.3 * canvas.noise(0.6, 0.08) + 0.1 * canvas.noise(1.0))


class _Model(NamedTuple):
    """A car's size and its profile from the front bumper over the roof to the rear bumper."""

    length: float  # [m]
    width: float  # [m]
    waist: float  # height [m] of the lower edge of the windows
    wheel: float  # radius [m] of the wheels
    places: tuple[float, ...]  # positions along the car from the front, in percent of its length
    heights: tuple[float, ...]  # of the profile at each place, in centimetres


_MODELS = (
    _Model(4.5, 1.78, 0.97, 0.32, (0, 1, 5, 29, 43, 72, 87, 99, 100), (25, 62, 76, 94, 142, 143, 100, 95, 25)),
    _Model(3.9, 1.72, 1.0, 0.32, (0, 1, 5, 24, 40, 84, 97, 99, 100), (25, 62, 78, 98, 150, 148, 102, 80, 25)),
    _Model(4.7, 1.8, 0.98, 0.32, (0, 1, 5, 27, 41, 90, 98, 99, 100), (25, 64, 78, 96, 147, 146, 100, 80, 25)),
    _Model(5.2, 1.95, 1.25, 0.35, (0, 1, 3, 12, 22, 97, 99, 99.5, 100), (28, 70, 95, 120, 205, 210, 120, 90, 28)),
)
_PARTS = ("nose", "nose", "bonnet", "glass", "roof", "glass", "boot", "tail")


def car(studio: Studio, middle: Ground, heading: Ground) -> None:
    """Park a car at ground point `middle`, facing along the unit vector `heading` (x, z), with its shadow."""
    rng = studio.rng
    model = _MODELS[int(rng.choice(4, p=[0.3, 0.3, 0.25, 0.15]))]
    albedo = float(rng.choice([0.03, 0.06, 0.13, 0.25, 0.4, 0.68]))
    middle, ahead = np.array(middle), np.array(heading)
    left = np.array([-ahead[1], ahead[0]])

    def place(fraction: float, height: float, across: float) -> np.ndarray:
        ground = middle + (0.5 - fraction) * model.length * ahead + across * left
        return np.array([ground[0], height, ground[1]])

    places, heights = np.array(model.places) / 100.0, np.array(model.heights) / 100.0
    side = _side(model, places, heights, albedo)
    half = 0.5 * model.width
    for across in (-half, half):
        start = place(0.0, 0.0, across)
        top = np.array([0.0, heights.max(), 0.0])
        studio.patch(start, place(1.0, 0.0, across) - start, top, side)
    profile = list(zip(places, heights, strict=True))
    for part, low, high in zip(_PARTS, profile, profile[1:], strict=False):
        start = place(*low, -half)
        studio.patch(start, place(*low, half) - start, place(*high, -half) - start, _across(part, albedo))
    under = footprint(middle, model.width + 0.2, model.length + 0.1, np.arctan2(-ahead[0], ahead[1]))
    studio.stain(under, 0.25)
    studio.stain(under - 0.8 * studio.light.sun[[0, 2]] / max(0.3, studio.light.sun[1]), 0.6)


@as_paint
def _side(canvas: Canvas, model: _Model, places, heights, albedo: float) -> tuple[Texture, Texture]:
    """The paint of a side: body, windows, doors, lamps and wheels, cut out along the profile."""
    fraction, y = canvas.x / canvas.width, canvas.y
    top = np.interp(fraction, places, heights)
    body = (y < top) & (y > float(heights[0]))
    shine = np.exp(-(((y - 0.82 * model.waist) / 0.05) ** 2)) - 0.5 * np.exp(-(((y - 0.6 * model.waist) / 0.08) ** 2))
    image = albedo * (0.6 + 0.4 * y / model.waist) + (0.08 + 0.2 * albedo) * shine + 0 * fraction
    image = np.where(y < 0.36, 0.04, image)
    window = (y > model.waist) & (y < top - 0.09)
    glass = 0.03 + 0.1 * np.clip(canvas.noise(0.9, 0.35), 0.0, 1.5)
    image = np.where(window, glass, image)
    for post in (0.36, 0.57, 0.78):
        pillar = np.abs(fraction - post - 0.02 * (y - model.waist)) < 0.012
        image = np.where(window & pillar, albedo, image)
        if post < 0.7:
            gap = (np.abs(fraction - post) < 0.003) & (y < model.waist) & (y > 0.4)
            image = np.where(gap, 0.02, image)
            handle = (np.abs(fraction - post - 0.12) < 0.02) & (np.abs(y - 0.86 * model.waist) < 0.02)
            image = np.where(handle, 0.02, image)
    lamp = (np.abs(y - 0.68) < 0.06) & (fraction < 0.06)
    tail = (np.abs(y - 0.82) < 0.09) & (fraction > 0.955)
    image = np.where(lamp, 0.8, np.where(tail, 0.12, image))
    mask = body
    for hub in (0.19, 0.8):
        radius = np.hypot((fraction - hub) * model.length, y - model.wheel)
        spokes = np.cos(5 * np.arctan2(y - model.wheel, (fraction - hub) * model.length)) > -0.3
        rim = np.where((radius < 0.6 * model.wheel) & spokes, 0.38, 0.025)
        image = np.where(radius < 1.16 * model.wheel, 0.015, image)
        image = np.where(radius < model.wheel, rim, image)
        mask = mask | (radius < model.wheel)
    grime = np.exp(0.12 * canvas.noise(0.9, 0.4, 6, 0.8))
    return (image * grime).astype(np.float32), mask.astype(np.float32)


@as_paint
def _across(canvas: Canvas, part: str, albedo: float) -> Texture:
    """The paint of a surface that spans the width of the car: bonnet, glass, roof and so on."""
    width, rise = canvas.width, canvas.y / canvas.height
    grime = np.exp(0.12 * canvas.noise(0.8, 0.4, 6, 0.8))
    if part == "glass":
        image = (0.04 + 0.16 * rise**2) * np.exp(0.35 * canvas.noise(0.7, 0.5)) + 0 * canvas.x
        for left, right in ((0.0, 0.06), (width - 0.06, width)):
            canvas.fill(image, left, right, 0.0, canvas.height, albedo)
        return image
    image = (albedo * (0.7 + 0.3 * rise) + 0 * canvas.x) * grime
    if part in ("bonnet", "roof", "boot"):
        mirrored = 0.12 * np.exp(0.4 * canvas.noise(0.9, 0.5))
        return image + mirrored
    if part == "nose" and canvas.height > 0.2:
        canvas.fill(image, 0.0, width, 0.0, 0.1, 0.04)
        canvas.fill(image, 0.45, width - 0.45, 0.06, 0.3, 0.03)
        canvas.fill(image, 0.5 * width - 0.26, 0.5 * width + 0.26, 0.1, 0.21, 0.7)
    elif part == "nose":
        canvas.fill(image, 0.42, width - 0.42, 0.0, canvas.height, 0.05)
        for left in (0.05, width - 0.4):
            canvas.fill(image, left, left + 0.35, 0.02, canvas.height - 0.02, 0.85)
    elif part == "tail":
        # The rear profile runs downwards, so the canvas is upside down.
        canvas.fill(image, 0.0, width, canvas.height - 0.12, canvas.height, 0.04)
        canvas.fill(image, 0.5 * width - 0.26, 0.5 * width + 0.26, 0.28, 0.39, 0.7)
        for left in (0.04, width - 0.29):
            canvas.fill(image, left, left + 0.25, 0.03, 0.2, 0.14)
    return image
