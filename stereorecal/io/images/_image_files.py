"""Image files: finding, decoding (strictly) and writing them."""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float, Num

from stereorecal._errors import InputError
from stereorecal.io._atomic import make_folder, write_bytes
from stereorecal.io._read_files import note_input
from stereorecal.io.images._image_headers import announced_size, bytes_per_pixel, ends_properly

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".jp2", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".pnm", ".webp")
MOST_PIXELS = 1 << 26  # of an image: 67 million, which take 0.2 GB to decode in colour
_MOST_BYTES = 1 << 28  # of an image, or of its file


def images_in(folder: Path) -> list[Path]:
    """The image files directly in `folder`, hidden ones left out, in natural order; none if it does not exist."""
    if not folder.is_dir():
        return []
    return natural_order(
        path
        for path in folder.iterdir()
        if path.suffix.lower() in IMAGE_SUFFIXES and path.is_file() and not path.name.startswith(".")
    )


def natural_order(paths: Iterable[Path]) -> list[Path]:
    """The paths sorted so that 9 comes before 10."""

    def key(path: Path) -> tuple[list[str | int], str]:
        parts = re.split(r"([0-9]+)", str(path))
        return [int(part) if index % 2 else part for index, part in enumerate(parts)], str(path)

    return sorted(paths, key=key)


def read_image(path: str) -> Num[np.ndarray, "..."]:
    """The pixels of an image file as stored, (h, w) or (h, w, c) in BGR order; EXIF orientation is ignored."""
    return decode_image(image_bytes(path), path)


def image_bytes(path: str) -> bytes:
    """The content of an image file."""
    note_input(path)
    try:
        with open(path, "rb") as file:
            data = file.read(_MOST_BYTES + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; check the path.") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the file.") from error
    return data


def decode_image(data: bytes, where: str) -> Num[np.ndarray, "..."]:
    """The pixels of what an image file holds, as `read_image` gives them.

    Raises:
        InputError: about `where`, if they are too many, truncated, or of no kind that OpenCV can read.
    """
    if not data:
        raise InputError(f"{where}: the file is empty; copy or record it again.")
    width, height = announced_size(data) or (0, 0)
    if width * height > MOST_PIXELS:
        raise InputError(f"{where}: the image claims to be {width}x{height}; at most {MOST_PIXELS} pixels are read.")
    if len(data) > _MOST_BYTES or width * height * bytes_per_pixel(data) > _MOST_BYTES:
        raise InputError(f"{where}: the image takes more than {_MOST_BYTES >> 20} MB; store it grey, or with 8 bit.")
    if not ends_properly(data):
        raise InputError(f"{where}: the image is truncated or damaged; copy or record it again.")
    with quiet_opencv():
        try:
            image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        except cv2.error:
            image = None
    if image is None:
        raise InputError(f"{where}: not an image that OpenCV can read, or a damaged one; give a PNG, JPEG or TIFF.")
    return image


def write_png(path: Path, image: Float[np.ndarray, "h w"]) -> None:
    """Write a grey image as 8-bit PNG, values rounded and clipped to 0..255; missing folders are made.

    Raises:
        InputError: if the place cannot be written to.
    """
    make_folder(path.parent)
    write_bytes(path, cv2.imencode(".png", np.clip(np.rint(image), 0, 255).astype(np.uint8))[1].tobytes())


@contextmanager
def quiet_opencv() -> Iterator[None]:
    """Silence OpenCV's own messages on stderr inside."""
    logging = cv2.utils.logging
    level = logging.getLogLevel()
    logging.setLogLevel(logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        logging.setLogLevel(level)
