"""Boats."""

import numpy as np

from stereorecal.synthetic.objects._building_paints import plain, weathered
from stereorecal.synthetic.objects._studio import Ground, Studio, footprint
from stereorecal.synthetic.rendering._noise import Texture
from stereorecal.synthetic.rendering._patch import Canvas, as_paint


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
