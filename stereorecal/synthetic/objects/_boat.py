"""Boats."""

import numpy as np

from stereorecal.synthetic.objects._building_paints import plain, weathered
from stereorecal.synthetic.objects._things import Things
from stereorecal.synthetic.rendering._noise import Texture
from stereorecal.synthetic.rendering._patch import Canvas, Opaque, Paint, Patch
from stereorecal.synthetic.rendering._patch_builder import Ground, Studio, footprint
from stereorecal.synthetic.surroundings._ground import Stain, mirrored


def boat(studio: Studio, middle: Ground, length: float, turn: float, mast: bool) -> Things:
    """A boat of `length` [m] with its keel along `turn` [rad] (0: along x), a wheelhouse and, if `mast`, a mast."""
    rng = studio.rng
    beam, freeboard = 0.3 * length, 0.11 * length + 0.35
    along, side = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    middle = np.array(middle)
    stern, waist, bow = (
        middle - 0.5 * length * along,
        middle + 0.2 * length * along,
        middle + 0.5 * length * along,
    )
    albedo = float(rng.choice([0.08, 0.2, 0.55, 0.75]))
    patches: list[Patch] = []
    for sign in (-1.0, 1.0):
        edge = 0.5 * sign * beam * side
        hull = _hull(albedo, freeboard)
        patches.append(studio.wall(stern + 0.9 * edge, waist + edge, 0.0, freeboard, hull, lean=0.06 * edge))
        patches.append(studio.wall(waist + edge, bow, 0.0, freeboard * 1.18, _bow(albedo, freeboard), lean=0.06 * edge))
    patches.append(
        studio.wall(stern - 0.45 * beam * side, stern + 0.45 * beam * side, 0.0, freeboard, _hull(albedo, freeboard))
    )
    deck = plain(0.45, 0.2)
    patches.append(
        studio.slab(
            stern - 0.45 * beam * side,
            stern + 0.45 * beam * side,
            0.72 * length * along,
            freeboard - 0.12,
            deck,
        )
    )
    cabin = middle + float(rng.uniform(-0.12, 0.05)) * length * along
    tall, long = float(rng.uniform(0.9, 1.5)), float(rng.uniform(0.25, 0.4)) * length
    patches += studio.box(
        (cabin[0], cabin[1]), (long, tall, 0.62 * beam), turn, freeboard - 0.1, _cabin(), plain(0.7, 0.15)
    )
    if mast:
        post = cabin + 0.1 * length * along
        patches.append(studio.pole(post, 0.11, freeboard, freeboard + 1.1 * length, 0.55))
        boom = post - 0.42 * length * along
        patches.append(studio.wall(boom, post, freeboard + 1.5, freeboard + 1.78, _sail()))
    patches.append(studio.pole(stern + 0.1 * along, 0.06, freeboard, freeboard + 1.0, 0.6))
    ends = (stern, bow)
    stains = [*mirrored(*ends, freeboard + 0.6, studio.eye, 0.35)]
    stains.append(Stain(footprint((middle[0], middle[1]), length + 0.5, beam + 0.7, turn), 0.5))
    return patches, stains


def _hull(albedo: float, freeboard: float) -> Opaque:
    """The side of a hull: waterline, sheer stripe, fenders or lettering."""

    def paint(canvas: Canvas) -> Texture:
        image = np.full(canvas.shape, albedo, np.float32)
        image = image * (0.75 + 0.35 * canvas.y / canvas.height)
        canvas.fill(image, 0.0, canvas.width, 0.0, 0.14, 0.06)
        canvas.fill(image, 0.0, canvas.width, 0.14, 0.2, 0.5)
        canvas.fill(image, 0.0, canvas.width, freeboard - 0.16, freeboard - 0.07, 0.12 if albedo > 0.3 else 0.6)
        for x in np.arange(0.7, canvas.width - 0.4, float(canvas.rng.uniform(0.9, 1.7))):
            canvas.fill(image, x, x + 0.2, 0.25 * freeboard, 0.75 * freeboard, float(canvas.rng.uniform(0.1, 0.8)))
        return weathered(canvas, image, 1.1)

    return paint


def _bow(albedo: float, freeboard: float) -> Paint:
    """The bow of a hull: the stem rakes forward and the sheer rises."""
    hull = _hull(albedo, freeboard)

    def paint(canvas: Canvas) -> tuple[Texture, Texture]:
        u = canvas.x / canvas.width
        stem = canvas.x < canvas.width - 0.35 * (1.0 - canvas.y / canvas.height)
        sheer = canvas.y < freeboard * (1.0 + 0.18 * u**2)
        return hull(canvas), (stem & sheer).astype(np.float32)

    return paint


def _cabin() -> Paint:
    """A wheelhouse with a row of windows."""

    def paint(canvas: Canvas) -> Texture:
        image = np.full(canvas.shape, float(canvas.rng.uniform(0.5, 0.8)), np.float32)
        step = float(canvas.rng.uniform(0.5, 0.8))
        for x in np.arange(0.14, canvas.width - 0.3, step):
            canvas.fill(image, x, x + step - 0.14, 0.5 * canvas.height, 0.86 * canvas.height, 0.05)
            canvas.fill(image, x, x + 0.4 * step, 0.7 * canvas.height, 0.86 * canvas.height, 0.12)
        return weathered(canvas, image, 0.9)

    return paint


def _sail() -> Paint:
    """A furled sail on its boom."""
    return lambda canvas: 0.5 * np.exp(0.3 * canvas.noise(0.6, 0.08) + 0.1 * canvas.noise(1.0))
