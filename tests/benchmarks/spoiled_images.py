"""Ways in which images are spoiled: half of them the model of the estimate explains, half of them it does not."""

import zlib
from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np

import stereorecal as sr

Images = tuple[np.ndarray, np.ndarray]
Spoil = Callable[[np.ndarray, np.ndarray, np.random.Generator], Images]


def spoiled(scene: sr.Scene, spoil: Spoil, case: str) -> sr.Scene:
    """The scene with spoiled images, of whole grey levels; each pair by a draw of its own."""
    pairs = []
    for number, pair in enumerate(scene.pairs):
        draw = np.random.default_rng([zlib.crc32(case.encode()), number])
        images = spoil(np.asarray(pair.left, float), np.asarray(pair.right, float), draw)
        left, right = (np.clip(np.round(image), 0, 255).astype(np.float32) for image in images)
        pairs.append(sr.Pair(left, right, pair.name))
    return replace(scene, pairs=tuple(pairs))


def grid(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of all pixels, float32."""
    y, x = np.mgrid[: image.shape[0], : image.shape[1]].astype(np.float32)
    return x, y


def taken_from(image: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The image at these places."""
    there = x.astype(np.float32), y.astype(np.float32)
    return cv2.remap(image.astype(np.float32), *there, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


def of_both(drawn: Callable[[np.ndarray, np.random.Generator], np.ndarray]) -> Spoil:
    """The same done to each image, left first."""
    return lambda left, right, draw: (drawn(left, draw), drawn(right, draw))


# --- what the model explains -------------------------------------------------------------------------------


def noise(sigma: float) -> Spoil:
    return of_both(lambda image, draw: image + draw.normal(0, sigma, image.shape))


def blur(sigma: float) -> Spoil:
    return lambda left, right, draw: (left, cv2.GaussianBlur(right, (0, 0), sigma))


def exposure(gain: float, gamma: float) -> Spoil:
    return lambda left, right, draw: (left, 255 * (right / 255) ** gamma * gain)


def jpeg(quality: int) -> Spoil:
    def coded(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        bytes_ = cv2.imencode(".jpg", image.round().clip(0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, quality])
        return cv2.imdecode(bytes_[1], cv2.IMREAD_GRAYSCALE).astype(float)

    return of_both(coded)


def spots(number: int, value: float, both: bool) -> Spoil:
    """Glints, or dirt on a lens."""

    def drawn(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        height, width = image.shape
        image = image.astype(np.float32).copy()
        for _ in range(number):
            centre = int(draw.integers(0, width)), int(draw.integers(0, height))
            axes = tuple(int(a) for a in draw.integers(1, max(3, width // 70), 2))
            cv2.ellipse(image, centre, axes, 0.0, 0.0, 360.0, value, -1)
        return image

    return of_both(drawn) if both else lambda left, right, draw: (left, drawn(right, draw))


def rain(number: int) -> Spoil:
    def drawn(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        height, width = image.shape
        layer = np.zeros_like(image, np.float32)
        for _ in range(number):
            x, y, length = int(draw.integers(0, width)), int(draw.integers(0, height)), int(draw.integers(8, 25))
            cv2.line(layer, (x, y), (x + length // 6, y + length), float(draw.uniform(20, 60)), 1)
        return image + cv2.GaussianBlur(layer, (0, 0), 0.8)

    return of_both(drawn)


def vignetting(left, right, draw):
    """The corners of the left image have lost 60 % of their light, those of the right one 30 %."""
    (height, width), (x, y) = left.shape, grid(left)
    r2 = 2.0 * ((x / width - 0.5) ** 2 + (y / height - 0.5) ** 2)
    return left * (1.0 - 0.6 * r2), right * (1.0 - 0.3 * r2)


EXPLAINED: dict[str, Spoil] = {
    "clean": lambda left, right, draw: (left, right),
    "noise 5": noise(5),
    "noise 12": noise(12),
    "blur 1": blur(1.0),
    "blur 2": blur(2.0),
    "darker": exposure(0.65, 1.15),
    "brighter": exposure(1.2, 0.9),
    "jpeg 20": jpeg(20),
    "jpeg 60": jpeg(60),
    "glints": spots(300, 255.0, True),
    "rain": rain(600),
    "dirt": spots(25, 60.0, False),
    "vignetting": vignetting,
    "shake": of_both(lambda image, draw: cv2.blur(image, (1, 9))),
}

# --- what it does not --------------------------------------------------------------------------------------


def warped(of_rows: Callable, of_columns: Callable) -> Spoil:
    """The right image, taken from (x + of_columns, y + of_rows), both functions of x and y from -1 to 1, in pixels."""

    def spoil(left, right, draw):
        (height, width), (x, y) = right.shape, grid(right)
        u, v = 2 * x / (width - 1) - 1, 2 * y / (height - 1) - 1
        return left, taken_from(right, x + of_columns(u, v), y + of_rows(u, v))

    return spoil


def none(u, v):
    return 0.0 * u


def patch(share: float, rows: float, columns: float = 0.0, shape: str = "block") -> Spoil:
    """A part of the right image has moved: a ship, a wave, a tree."""

    def spoil(left, right, draw):
        (height, width), (x, y) = right.shape, grid(right)
        if shape == "block":
            h, w = int(height * share**0.5), int(width * share**0.5)
            top, first = int(draw.integers(0, height - h + 1)), int(draw.integers(0, width - w + 1))
            inside = (y >= top) & (y < top + h) & (x >= first) & (x < first + w)
        elif shape == "left":
            inside = x < share * width
        else:
            inside = y > (1 - share) * height
        return left, taken_from(right, x + np.float32(columns) * inside, y + np.float32(rows) * inside)

    return spoil


def interlaced(columns: float, rows: float) -> Spoil:
    """Every other row of the right image is of a later field."""

    def spoil(left, right, draw):
        later = warped(lambda u, v: rows + none(u, v), lambda u, v: columns + none(u, v))(left, right, draw)[1]
        mixed = right.copy()
        mixed[1::2] = later[1::2]
        return left, mixed

    return spoil


def stretched(percent: float) -> Spoil:
    return lambda left, right, draw: warped(lambda u, v: percent / 200 * right.shape[0] * v, none)(left, right, draw)


def sheared(percent: float) -> Spoil:
    return lambda left, right, draw: warped(none, lambda u, v: percent / 200 * right.shape[0] * v)(left, right, draw)


def rolling(rows: float, columns: float) -> Spoil:
    """A rolling shutter in the right camera alone, of a rig that turns: the lower, the later."""
    return warped(lambda u, v: rows * (v + 1) / 2, lambda u, v: columns * (v + 1) / 2)


UNEXPLAINED: dict[str, Spoil] = {
    "patch 20 %, 1 row": patch(0.2, 1),
    "patch 20 %, 3 rows": patch(0.2, 3),
    "patch 40 %, 1 row": patch(0.4, 1),
    "patch 40 %, 2 rows": patch(0.4, 2),
    "patch 60 %, 3 rows": patch(0.6, 3),
    "left 30 %, 2 rows": patch(0.3, 2, 0, "left"),
    "below 40 %, 1 row": patch(0.4, 1, 0, "below"),
    "stretched 0.1 %": stretched(0.1),
    "stretched 0.5 %": stretched(0.5),
    "sheared 0.3 %": sheared(0.3),
    "sheared 1 %": sheared(1.0),
    "rolling 1 row, 3 columns": rolling(1, 3),
    "rolling 3 rows": rolling(3, 0),
    "interlaced 2 columns": interlaced(2, 0),
    "jpeg 5": jpeg(5),
    "jpeg 10": jpeg(10),
}
# First run once the rules stood.
UNSEEN: dict[str, Spoil] = {
    "patch 30 %, 2 rows, 3 columns": patch(0.3, 2, 3),
    "patch 50 %, 1 row": patch(0.5, 1),
    "patch 50 %, 3 rows": patch(0.5, 3),
    "patch 20 %, 2 rows": patch(0.2, 2),
    "left 50 %, 1 row": patch(0.5, 1, 0, "left"),
    "below 25 %, 3 rows": patch(0.25, 3, 4, "below"),
    "stretched 0.3 %": stretched(0.3),
    "stretched 1 %": stretched(1.0),
    "sheared 0.1 %": sheared(0.1),
    "rolling 2 rows, 6 columns": rolling(2, 6),
    "rolling 0.5 rows, 10 columns": rolling(0.5, 10),
    "interlaced 1 row": interlaced(0, 1),
    "barrel": warped(lambda u, v: 1.5 * v * (u * u + v * v), lambda u, v: 1.5 * u * (u * u + v * v)),
    "keystone": warped(lambda u, v: 1.0 * u * v, none),
    "jpeg 15": jpeg(15),
}
# A third group, written before the rule that whole regions must not be lost, and never looked at while it was made.


def smooth_field(pixels: float, grain: float) -> Spoil:
    """Rows and columns of the right image displaced by a smooth random field: haze over hot ground, water on glass."""

    def spoil(left, right, draw):
        height, width = right.shape
        sigma = grain * width

        def field() -> np.ndarray:
            drawn = cv2.GaussianBlur(draw.normal(0, 1, (height, width)).astype(np.float32), (0, 0), sigma)
            return pixels * drawn / drawn.std()

        x, y = grid(right)
        return left, taken_from(right, x + field(), y + field())

    return spoil


def crowd(number: int, share: float, rows: float) -> Spoil:
    """Several things, each with a motion of its own."""

    def spoil(left, right, draw):
        for _ in range(number):
            motion = draw.uniform(-rows, rows), draw.uniform(-2 * rows, 2 * rows)
            left, right = patch(share, *motion)(left, right, draw)
        return left, right

    return spoil


def turned_patch(share: float, degrees: float) -> Spoil:
    """A part that has turned: a boat that rolls."""

    def spoil(left, right, draw):
        height, width = right.shape
        side = float(np.sqrt(share * height * width))
        centre = draw.uniform(0.3, 0.7) * width, draw.uniform(0.3, 0.7) * height
        u, v = (axis - middle for axis, middle in zip(grid(right), centre, strict=True))
        cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        whole = taken_from(right, centre[0] + cos * u - sin * v, centre[1] + sin * u + cos * v)
        return left, np.where(np.hypot(u, v) < side / np.sqrt(np.pi), whole, right)

    return spoil


def blocks(pixels: float) -> Spoil:
    """A video codec that moves blocks of 16 pixels by its own motion vectors, in both images."""

    def coded(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        height, width = image.shape
        number = -(-height // 16), -(-width // 16)
        down, across = (np.kron(draw.choice([-pixels, 0.0, 0.0, pixels], number), np.ones((16, 16))) for _ in "yx")
        x, y = grid(image)
        return taken_from(image, x + across[:height, :width], y + down[:height, :width])

    return of_both(coded)


def veil(share: float) -> Spoil:
    """The sun beside one lens: a part of the image is white."""

    def spoil(left, right, draw):
        (height, width), (x, y) = right.shape, grid(right)
        away = np.hypot(x - draw.uniform(0, width), y - draw.uniform(0, height / 3))
        return left, right + 255.0 * np.exp(-((away / (share * width)) ** 2))

    return spoil


def focus(sigma: float) -> Spoil:
    """One lens that is out of focus to one side."""

    def spoil(left, right, draw):
        weight = np.linspace(0.0, 1.0, right.shape[1])
        return left, (1.0 - weight) * right + weight * cv2.GaussianBlur(right, (0, 0), sigma)

    return spoil


def bar(share: float) -> Spoil:
    """A wiper, or a rope, before one camera: other rows behind it, none of them right."""

    def spoil(left, right, draw):
        (height, width), (x, y) = right.shape, grid(right)
        inside = np.abs(x - width / 2 - (y - height / 2) * draw.uniform(-1, 1)) < share * width / 2
        return left, np.where(inside, 40.0 + draw.normal(0, 3, right.shape), right)

    return spoil


NEW: dict[str, Spoil] = {
    "haze 0.7 px": smooth_field(0.7, 0.03),
    "water on glass 2 px": smooth_field(2.0, 0.15),
    "crowd of 5": crowd(5, 0.08, 3.0),
    "turned part": turned_patch(0.3, 1.0),
    "vibration 1 row": warped(lambda u, v: np.sin(9.0 * v) + none(u, v), none),
    "band 25 %, 2 rows": warped(lambda u, v: 2.0 * (np.abs(v - 0.1) < 0.25) + none(u, v), none),
    "codec blocks": blocks(1.0),
    "veil": veil(0.35),
    "focus to one side": focus(3.0),
    "wiper": bar(0.15),
}
# A yaw, every other line half a row of pitch, a focal length, a lens: parameters of the model, to the last pixel.
OF_THE_MODEL = ("keystone", "interlaced 1 row", "stretched", "barrel")
KINDS = {"seen": EXPLAINED | UNEXPLAINED, "unseen": UNSEEN, "new": NEW}
