"""Whether a pair shows enough to be matched at all: light and texture, however the rig stands."""

from dataclasses import dataclass

import cv2
import numpy as np

from stereorecal.recordings import Pair

_WIDTH = 128  # pixels: at which texture is looked at; noise averages out on the way
_BLOCK = 2  # columns: noise of neighbours is alike where colours were interpolated
_STEEP = 8.0  # x-Sobel response, four times a step in grey levels: fog and noise stay below
_DARK = 20.0  # mean grey level; what moves at night is noise
_ALIKE = 0.2  # correlation of slopes in two halves of an image's columns; of noise 0, of things 0.6 and more
_TEXTURED = 1.0 / 3.0  # of the image; daylight shows 0.5 to 0.9, night and fog 0 to 0.2


@dataclass(frozen=True)
class Legible:
    """Of the image of a pair that shows less.

    Attributes:
        brightness: mean grey level, 0 to 255.
        texture: share of the image with texture; that of noise counts.
        noise: there is no other texture, as behind a lens cap, whose image of 16 bit or floating point is stretched to
            full contrast.
    """

    brightness: float
    texture: float
    noise: bool = False

    @property
    def dark(self) -> bool:
        """True if it is too dark to match."""
        return self.brightness < _DARK

    @property
    def enough(self) -> bool:
        """True if images of an aligned rig would match."""
        return not self.dark and not self.noise and self.texture >= _TEXTURED


def legible(pair: Pair) -> Legible:
    """How much a pair shows."""
    images = [np.asarray(image, np.float32) for image in (pair.left, pair.right)]
    brightness, texture = min(float(image.mean()) for image in images), min(_texture(image) for image in images)
    return Legible(brightness, texture, texture >= _TEXTURED and any(_noise(image) for image in images))


def _texture(image: np.ndarray) -> float:
    height, width = image.shape
    small = cv2.resize(image, (_WIDTH, max(1, height * _WIDTH // width)), interpolation=cv2.INTER_AREA)
    return float((np.abs(cv2.Sobel(small, cv2.CV_32F, 1, 0)) > _STEEP).mean())


def _noise(image: np.ndarray) -> bool:
    """Whether columns, two and two in turn, have nothing in common: all see the same things, each its own noise."""
    height, width = image.shape
    if width < 8 * _BLOCK:
        return False
    columns = image[:, : width // (2 * _BLOCK) * 2 * _BLOCK].reshape(height, -1, 2, _BLOCK).mean(axis=-1)
    size = min(_WIDTH, columns.shape[1])
    halves = [
        cv2.resize(
            np.ascontiguousarray(columns[:, :, half]),
            (size, max(1, height * size // width)),
            interpolation=cv2.INTER_AREA,
        )
        for half in (0, 1)
    ]
    first, second = (cv2.Sobel(half, cv2.CV_32F, 1, 0) for half in halves)
    energy = float(np.sqrt((first**2).sum() * (second**2).sum()))
    return energy > 0.0 and float((first * second).sum()) < _ALIKE * energy
