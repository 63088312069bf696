"""A house: front, side walls, gables, a roof and a chimney."""

import numpy as np

from stereorecal.synthetic.objects._building_paints import plain, tiles
from stereorecal.synthetic.objects._studio import Ground, Studio
from stereorecal.synthetic.rendering._noise import Texture
from stereorecal.synthetic.rendering._patch import Canvas, Opaque, as_paint


def house(
    studio: Studio, a: Ground, b: Ground, depth: float, low: float, tall: float, front: Opaque, side: Opaque
) -> None:
    """Build a house whose front stands over the ground line a-b; it extends `depth` [m] away from the camera.

    Args:
        low: height [m] of its foot.
        tall: height [m] of the walls, from the foot to the eaves.
        front, side: paints of the front and of the side walls.
    """
    rng = studio.rng
    a, b = np.array(a, float), np.array(b, float)
    along = (b - a) / np.linalg.norm(b - a)
    away = np.array([-along[1], along[0]])
    away = away * (np.sign(away @ (a + b)) or 1.0)
    eaves, rise = low + tall, 0.5 * depth * rng.uniform(0.6, 0.95)
    studio.wall(a, b, low, eaves, front)
    for corner, outwards in ((a, -along), (b, along)):
        if outwards @ corner < 1.0:
            studio.wall(corner, corner + depth * away, low, eaves, side)
            studio.wall(corner, corner + depth * away, eaves, eaves + rise, _gable(side))
    over = 0.3
    foot_a, foot_b = a - over * (away + along), b + over * (along - away)
    drop = over * rise / (0.5 * depth)
    roof = tiles(rng.uniform(0.07, 0.2))
    studio.wall(foot_a, foot_b, eaves - drop, eaves + rise, roof, lean=(0.5 * depth + over) * away)
    # A fascia board under the eaves.
    studio.wall(foot_a, foot_b, eaves - drop - 0.16, eaves - drop, plain(0.5))
    if rng.uniform() < 0.8:
        spot = a + rng.uniform(0.15, 0.85) * (b - a) + 0.45 * depth * away
        stack = plain(rng.uniform(0.12, 0.3), 0.3)
        studio.box(spot, (0.7, 0.5 * rise + 0.6, 0.7), 0.0, eaves + 0.5 * rise, stack, stack)


@as_paint
def _gable(canvas: Canvas, side: Opaque) -> tuple[Texture, Texture]:
    """A side wall cut to a triangle."""
    inset = np.minimum(canvas.x, canvas.width - canvas.x)
    return side(canvas), (canvas.y < inset * (2.0 * canvas.height / canvas.width)).astype(np.float32)
