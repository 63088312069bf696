"""The scale of disparity pictures, as a picture with its ends."""

from dataclasses import dataclass

import numpy as np

from stereorecal.report._embedded_images import data_uri, disparity_picture

_SIZE = 256, 12  # pixels


@dataclass(frozen=True)
class ColourBar:
    """From the colour of `least` on the left to that of `largest` on the right, in pixels of disparity."""

    picture: str
    least: float
    largest: float


def colour_bar(least: float, largest: float) -> ColourBar:
    """The scale of pictures that `disparity_picture` makes with the same ends."""
    width, height = _SIZE
    values = np.tile(np.linspace(least, largest, width), (height, 1))
    return ColourBar(
        data_uri(disparity_picture(values, np.ones(values.shape, bool), least, largest, width)), least, largest
    )
