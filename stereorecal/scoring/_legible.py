"""Whether a pair shows enough to be matched at all: light and texture, however the rig stands."""

from dataclasses import dataclass

import cv2
import numpy as np

from stereorecal.recordings import Pair

_WIDTH = 128  # pixels: at which texture is looked at; noise averages out on the way
_STEEP = 8.0  # x-Sobel response, four times a step in grey levels: fog and noise stay below
_DARK = 20.0  # mean grey level; what moves at night is noise
_TEXTURED = 1.0 / 3.0  # of the image; daylight shows 0.5 to 0.9, night and fog 0 to 0.2


@dataclass(frozen=True)
class Legible:
    """Of the image of a pair that shows less.

    Attributes:
        brightness: mean grey level, 0 to 255.
        texture: share of the image with texture.
    """

    brightness: float
    texture: float

    @property
    def dark(self) -> bool:
        """True if it is too dark to match."""
        return self.brightness < _DARK

    @property
    def enough(self) -> bool:
        """True if images of an aligned rig would match."""
        return not self.dark and self.texture >= _TEXTURED


def legible(pair: Pair) -> Legible:
    """How much a pair shows."""
    images = [np.asarray(image, np.float32) for image in (pair.left, pair.right)]
    return Legible(min(float(image.mean()) for image in images), min(_texture(image) for image in images))


def _texture(image: np.ndarray) -> float:
    height, width = image.shape
    small = cv2.resize(image, (_WIDTH, max(1, height * _WIDTH // width)), interpolation=cv2.INTER_AREA)
    return float((np.abs(cv2.Sobel(small, cv2.CV_32F, 1, 0)) > _STEEP).mean())
