"""Houses, and paints of built surfaces: masonry, paving, boards, corrugated steel, house fronts, roof tiles."""

import numpy as np

from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Canvas, Opaque, as_paint
from stereorecal.synthetic._studio import Ground, Studio


def weathered(canvas: Canvas, albedo: Texture, amount: float = 1.0) -> Texture:
    """The albedo with blotches and streaks of running water, darkened towards the foot."""
    blotches = canvas.noise(1.5, 1.0, 7, 0.75)
    streaks = np.minimum(canvas.noise(0.12, 2.5, 3), 0.3)
    foot = 1.0 - 0.3 * np.exp(-canvas.y / 0.25)
    return albedo * np.exp(amount * (0.17 * blotches + 0.16 * streaks)) * foot


def _courses(canvas: Canvas, width: float, height: float, joint: float) -> tuple[Texture, Texture]:
    """Courses of blocks, each shifted by half a block, as two textures: a random number 0..1 for each block, and the
    coverage 0..1 of the joints."""
    row = np.floor(canvas.y / height)
    x = canvas.x / width + 0.5 * np.mod(row, 2)
    column = np.floor(x)
    # The usual hash of graphics shaders: the fraction of a large sine.
    mixed = np.sin(row * 12.9898 + column * 78.233 + canvas.rng.uniform(0, 9)) * 43758.5453
    edge_x = np.minimum(x - column, column + 1.0 - x) * width
    edge_y = np.minimum(canvas.y / height - row, row + 1.0 - canvas.y / height) * height
    gap = np.minimum(edge_x, edge_y)
    soft = max(joint, 0.5 * canvas.texel)
    return (mixed - np.floor(mixed)).astype(np.float32), np.clip(1.5 - gap / soft, 0.0, 1.0) * min(1.0, joint / soft)


@as_paint
def masonry(
    canvas: Canvas, albedo: float, width: float, height: float, joint: float = 0.012, contrast: float = 0.5
) -> Texture:
    """Bricks or stone blocks of `width` by `height` [m]."""
    tint, joints = _courses(canvas, width, height, joint)
    stone = albedo * (1.0 + contrast * (tint - 0.5)) * (1.0 + 0.14 * canvas.noise(0.5 * height))
    return weathered(canvas, stone * (1.0 - 0.55 * joints))


@as_paint
def quay(canvas: Canvas, albedo: float, tide: float) -> Texture:
    """A quay wall of stone blocks, wet and overgrown with weed up to `tide` [m]."""
    image = masonry(albedo, 1.3, 0.55, 0.03, 0.45)(canvas)
    ragged = canvas.y - tide - 0.12 * canvas.noise(1.2, 0.6)
    wet = np.clip(0.5 - ragged / 0.25, 0.0, 1.0)
    weed = 0.045 * np.exp(0.45 * canvas.noise(0.4, 0.5))
    image = image * (1 - wet) + wet * weed
    canvas.fill(image, 0.0, canvas.width, canvas.height - 0.22, canvas.height, 0.0)
    cap = 0.42 * np.exp(0.15 * canvas.noise(1.5, 0.2))
    return np.where(image == 0.0, cap, image)


@as_paint
def paving(canvas: Canvas, albedo: float) -> Texture:
    """Worn paving slabs."""
    tint, joints = _courses(canvas, 1.2, 0.8, 0.02)
    slab = albedo * (1.0 + 0.3 * (tint - 0.5)) * (1.0 - 0.4 * joints)
    return slab * np.exp(0.22 * canvas.noise(2.0))


@as_paint
def boards(canvas: Canvas, albedo: float, width: float = 0.18, upright: bool = True) -> Texture:
    """Planks, each with its own tint and grain."""
    position = (canvas.x if upright else canvas.y) / width + 0 * (canvas.x + canvas.y)
    board = np.floor(position)
    mixed = np.sin(board * 91.7 + canvas.rng.uniform(0, 9)) * 47453.5
    tint = mixed - np.floor(mixed)
    grain = canvas.noise(*((0.04, 1.2) if upright else (1.2, 0.04)))
    gap = np.clip(1.0 - np.minimum(position - board, board + 1 - position) * width / 0.012, 0.0, 1.0)
    image = albedo * (0.7 + 0.6 * tint) * np.exp(0.2 * grain) * (1.0 - 0.6 * gap)
    return weathered(canvas, image.astype(np.float32), 0.7)


@as_paint
def corrugated(canvas: Canvas, albedo: float) -> Texture:
    """The wall of a shipping container: ribs, rust, a frame and lettering."""
    ribs = 1.0 + 0.2 * np.sin(canvas.x * (2 * np.pi / 0.28)) + 0 * canvas.y
    rust = np.clip(canvas.noise(0.8, 1.2, gain=0.8) - 0.7, 0.0, 1.0)
    image = albedo * ribs * (1.0 - rust) + 0.09 * rust
    _lettering(canvas, image, min(0.92, 2.2 * albedo + 0.1))
    for low in (0.0, canvas.height - 0.14):
        canvas.fill(image, 0.0, canvas.width, low, low + 0.14, 0.6 * albedo)
    for left in (0.0, canvas.width - 0.14):
        canvas.fill(image, left, left + 0.14, 0.0, canvas.height, 0.6 * albedo)
    return weathered(canvas, image.astype(np.float32), 0.9)


def _lettering(canvas: Canvas, image: Texture, value: float) -> None:
    """Draw a line of strokes that resembles letters into `image`."""
    size = 0.16 * canvas.height
    x, y = 0.12 * canvas.width, canvas.height * canvas.rng.uniform(0.45, 0.7)
    while x < 0.7 * canvas.width:
        stroke = canvas.rng.uniform(0.1, 0.3) * size
        canvas.fill(image, x, x + stroke, y, y + size, value)
        if canvas.rng.uniform() < 0.6:
            level = y + size * canvas.rng.uniform(0.0, 0.8)
            canvas.fill(image, x, x + 0.6 * size, level, level + 0.2 * size, value)
        x += 0.75 * size


@as_paint
def facade(canvas: Canvas, albedo: float, storey: float = 2.9, base: Opaque | None = None) -> Texture:
    """A house front: plaster or brick with rows of windows, a door, a plinth and a cornice."""
    rng = canvas.rng
    image = base(canvas) if base else weathered(canvas, np.full(canvas.shape, albedo, np.float32), 0.65)
    bay = rng.uniform(1.9, 2.9)
    count = max(1, int(canvas.width / bay))
    bay, width, height = canvas.width / count, rng.uniform(0.9, 1.2), rng.uniform(1.3, 1.7)
    door = int(rng.integers(count))
    frame = float(rng.choice([0.12, 0.6, 0.75]))
    trim = albedo * float(rng.choice([0.7, 1.35]))
    for level in range(int(canvas.height / storey)):
        for column in range(count):
            x = (column + 0.5) * bay
            low, high = level * storey + 0.95, level * storey + 0.95 + height
            if level == 0 and column == door:
                canvas.fill(image, x - 0.62, x + 0.62, 0.0, 2.35, trim)
                canvas.fill(image, x - 0.5, x + 0.5, 0.0, 2.2, rng.uniform(0.04, 0.25))
                canvas.fill(image, x - 0.3, x + 0.3, 1.2, 2.0, 0.05)
                continue
            _window(canvas, image, x, low, high, 0.5 * width, frame, trim)
    for low, high, value in ((0.0, 0.45, 0.6), (canvas.height - 0.3, canvas.height, 1.25)):
        rows = (canvas.y >= low) & (canvas.y < high)
        image = np.where(rows, image * np.float32(value), image)
    canvas.fill(image, canvas.width - 0.16, canvas.width - 0.07, 0.0, canvas.height, 0.5 * albedo)
    return image * np.exp(0.05 * canvas.noise(0.15, octaves=5, gain=0.9))


def _window(canvas: Canvas, image: Texture, x, low, high, half, frame: float, trim: float) -> None:
    """Draw a window into `image`: dark glass, curtains or a blind, bars, a sill and the shadow of the lintel."""
    rng = canvas.rng
    canvas.fill(image, x - half - 0.1, x + half + 0.1, low - 0.05, high + 0.12, trim)
    canvas.fill(image, x - half - 0.18, x + half + 0.18, low - 0.14, low - 0.05, min(0.9, 1.4 * trim))
    canvas.fill(image, x - half, x + half, low, high, frame)
    glass = rng.uniform(0.03, 0.12)
    inner = half - 0.06
    canvas.fill(image, x - inner, x + inner, low + 0.06, high - 0.06, glass)
    canvas.fill(image, x - inner, x + inner, high - 0.22, high - 0.06, 0.5 * glass)
    if rng.uniform() < 0.6:
        drape = rng.uniform(0.2, 0.5) * inner
        canvas.fill(image, x - inner, x - inner + drape, low + 0.06, high - 0.2, rng.uniform(0.15, 0.4))
        canvas.fill(image, x + inner - drape, x + inner, low + 0.06, high - 0.2, rng.uniform(0.15, 0.4))
    else:
        edge = low + rng.uniform(0.3, 0.8) * (high - low)
        canvas.fill(image, x - inner, x + inner, edge, high - 0.2, rng.uniform(0.12, 0.45))
    canvas.fill(image, x - 0.03, x + 0.03, low, high, frame)
    canvas.fill(image, x - half, x + half, low + 0.62 * (high - low), low + 0.66 * (high - low), frame)


@as_paint
def tiles(canvas: Canvas, albedo: float) -> Texture:
    """Roof tiles."""
    tint, joints = _courses(canvas, 0.25, 0.33, 0.03)
    image = albedo * (0.75 + 0.5 * tint) * (1.0 - 0.5 * joints)
    return image * np.exp(0.25 * canvas.noise(2.5, 1.5))


@as_paint
def plain(canvas: Canvas, albedo: float, blotch: float = 0.12) -> Texture:
    """One material with soft blotches."""
    return albedo * np.exp(blotch * canvas.noise(0.8, gain=0.8))


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
