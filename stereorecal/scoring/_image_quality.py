"""Image quality: whether a pair has enough light and texture to be matched, whatever the calibration."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.recordings import Pair

_WIDTH = 128  # pixels: the scale at which texture is measured; finer texture is often noise
_BLOCK = 2  # columns: the noise of neighbouring pixels is correlated where colours were interpolated
_TEXTURED_SLOPE = 8.0  # x-Sobel response, four times a step in grey levels: fog and noise stay below
_DARK = 20.0  # mean grey level; what moves at night is noise
_CORRELATED = 0.2  # correlation of slopes in two halves of an image's columns: 0 for noise, 0.6 and more for texture
_TEXTURED = 1.0 / 3.0  # of the image; daylight shows 0.5 to 0.9, night and fog 0 to 0.2


@dataclass(frozen=True)
class ImageQuality:
    """The quality of the worse image of a pair.

    Attributes:
        brightness: mean grey level, 0 to 255.
        texture: share of the image with texture, 0 to 1; noise counts as texture.
        noise: True if the texture is noise only, as behind a lens cap, whose image of 16 bit or floating point is
            stretched to full contrast.
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


def image_quality(pair: Pair) -> ImageQuality:
    """The quality of a pair's images."""
    images = [np.asarray(image, np.float32) for image in (pair.left, pair.right)]
    brightness = min(float(image.mean()) for image in images)
    texture = min(float((np.abs(x_slopes(image)) > _TEXTURED_SLOPE).mean()) for image in images)
    return ImageQuality(brightness, texture, texture >= _TEXTURED and any(_is_noise(image) for image in images))


def x_slopes(image: Float[np.ndarray, "h w"]) -> Float[np.ndarray, "rows columns"]:
    """The x-Sobel response of the image at a width of 128 pixels."""
    height, width = image.shape
    return cv2.Sobel(_resized(image, _WIDTH, max(1, height * _WIDTH // width)), cv2.CV_32F, 1, 0)


def _is_noise(image: Float[np.ndarray, "h w"]) -> bool:
    """Whether the slopes of alternating pairs of columns are uncorrelated: texture is in both, noise is independent."""
    height, width = image.shape
    if width < 8 * _BLOCK:
        return False
    columns = image[:, : width // (2 * _BLOCK) * 2 * _BLOCK].reshape(height, -1, 2, _BLOCK).mean(axis=-1)
    size = min(_WIDTH, columns.shape[1])
    halves = [
        _resized(np.ascontiguousarray(columns[:, :, half]), size, max(1, height * size // width)) for half in (0, 1)
    ]
    first, second = (cv2.Sobel(half, cv2.CV_32F, 1, 0) for half in halves)
    energy = float(np.sqrt((first**2).sum() * (second**2).sum()))
    return energy > 0.0 and float((first * second).sum()) < _CORRELATED * energy


def _resized(image: Float[np.ndarray, "h w"], width: int, height: int) -> Float[np.ndarray, "rows columns"]:
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
