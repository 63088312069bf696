"""The frames of one camera (files, a video, a topic of a bag), read one by one."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError

Image = Any  # an array as OpenCV has it: (h, w), or (h, w, 3 or 4) in BGR order


@dataclass(frozen=True, eq=False)
class FrameSource:
    """Frames by number.

    Attributes:
        where: what error messages are about.
        names: of the frames.
        times: (n,) seconds, ascending; None if they are not known.
        read: makes the image of a number; raises InputError if it is damaged.
    """

    where: str
    names: tuple[str, ...]
    times: Float[np.ndarray, "n"] | None
    read: Callable[[int], Image]


def halves(source: FrameSource) -> tuple[FrameSource, FrameSource]:
    """The left and the right half of frames that show both images side by side. A frame is read once for both: to read
    one again, a video would be searched from its beginning."""
    cached = replace(source, read=lru_cache(maxsize=1)(source.read))
    return replace(source, read=lambda index: _half(cached, index, 0)), replace(
        source, read=lambda index: _half(cached, index, 1)
    )


def _half(source: FrameSource, index: int, side: int) -> Image:
    image = source.read(index)
    width = image.shape[1]
    if width % 2:
        raise InputError(
            f"{source.names[index]}: the image is {width} pixels wide, which cannot be halved; left and right image "
            "must have the same size."
        )
    return image[:, side * width // 2 : (side + 1) * width // 2]
