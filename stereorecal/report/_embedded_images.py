"""Images embedded in a page: JPEG of bounded size, as data URIs; and the colour scale of disparities."""

import base64
from typing import Any

import cv2
import matplotlib
import numpy as np
from jaxtyping import Bool, Float, UInt8

_QUALITY = 80
_OF_SQUARE = 0.75
_LINES = 14  # over the height of a picture
LINE_COLOURS = ((255, 176, 0), (0, 220, 255))  # in turn, so that the eye does not slip from one line to the next
_INVALID = (32, 32, 32)
_BAR_SIZE = 256, 12  # pixels

Grey = Float[np.ndarray, "h w"]
Picture = UInt8[np.ndarray, "tall wide 3"]


def rows_picture(left: Grey, right: Grey, width: int) -> Picture:
    """Left and right image side by side, each at most `width` wide, with lines along which rows should agree."""
    both = np.concatenate([_shrunk(left, width), _shrunk(right, width)], axis=1)
    picture = np.repeat(both.clip(0, 255).astype(np.uint8)[..., None], 3, axis=-1)
    for index, row in enumerate(line_rows(len(picture))):
        picture[row] = LINE_COLOURS[index % 2]
    return picture


def line_rows(height: int) -> list[int]:
    """The rows of a picture that lines are drawn along."""
    return np.linspace(0, height, _LINES + 2)[1:-1].astype(int).tolist()


def disparity_picture(
    values: Grey, valid: Bool[np.ndarray, "h w"], least: float, largest: float, width: int
) -> Picture:
    """Disparities in colours from `least` to `largest`, at most `width` wide; dark where there is none."""
    colours = matplotlib.colormaps["viridis"]((np.where(valid, values, 0.0) - least) / (largest - least))[..., :3]
    picture = np.where(valid[..., None], (255 * colours).round(), _INVALID).astype(np.uint8)
    return _shrunk(picture, width)


def data_uri(picture: Picture) -> str:
    """The RGB picture as the text of a JPEG."""
    data = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1].tobytes()
    return f"data:image/jpeg;base64,{base64.b64encode(data).decode('ascii')}"


def colour_bar(least: float, largest: float) -> dict[str, Any]:
    """The scale of pictures that `disparity_picture` makes with the same ends, in pixels of disparity: its `picture`,
    from the colour of `least` on the left to that of `largest` on the right."""
    width, height = _BAR_SIZE
    values = np.tile(np.linspace(least, largest, width), (height, 1))
    picture = disparity_picture(values, np.ones(values.shape, bool), least, largest, width)
    return {"picture": data_uri(picture), "least": least, "largest": largest}


def _shrunk(image: np.ndarray, width: int) -> np.ndarray:
    """The image at most `width` wide, and no larger in area than three quarters of its square."""
    tall, wide = image.shape[:2]
    scale = min(1.0, width / wide, (_OF_SQUARE * width**2 / (wide * tall)) ** 0.5)
    size = max(1, round(scale * wide)), max(1, round(scale * tall))
    return image if scale == 1.0 else cv2.resize(image, size, interpolation=cv2.INTER_AREA)
