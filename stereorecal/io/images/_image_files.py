"""Image files: finding, decoding and writing them; the size that a header announces, before a decoder reserves memory
for it; and how an image is turned."""

import io
import math
import re
import threading
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float, Num

from stereorecal._arrays import eight_bit
from stereorecal._errors import InputError
from stereorecal.io._atomic import make_folder, write_bytes
from stereorecal.io._read_files import about, check_there, note_input, read_bytes

Pixels = Num[np.ndarray, "..."]
_PNG, _JPEG = b"\x89PNG", b"\xff\xd8"
_KINDS = ("PNG", "JPEG", "BMP", "PPM", "TIFF", "JPEG2000", "WEBP")  # Pillow's names
_ORIENTATION = 274  # a tag of EXIF
_ALONE = threading.Lock()  # for filters of warnings, which all threads share
_DAMAGED = "the image is truncated or damaged; copy or record it again."

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".jp2", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".pnm", ".webp")
MOST_PIXELS = 1 << 26  # of an image: 67 million, which take 0.2 GB to decode in colour, 0.5 GB at most
_MOST_BYTES = 1 << 28  # of a file


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
    split = re.compile(r"([0-9]+)").split
    return sorted(paths, key=lambda path: ([int(x) if i % 2 else x for i, x in enumerate(split(str(path)))], str(path)))


def read_image(path: str) -> tuple[Pixels, int]:
    """The pixels of an image file as stored, (h, w) or (h, w, c) in BGR order, and its EXIF orientation, 1 to 8."""
    return decode_image(image_bytes(path), path)


def image_bytes(path: str) -> bytes:
    """The content of an image file."""
    note_input(path)
    check_there(Path(path))
    return read_bytes(path, _MOST_BYTES + 1)


def decode_image(data: bytes, where: str) -> tuple[Pixels, int]:
    """What `read_image` gives, of what an image file holds; a TIFF has orientation 1, since OpenCV always turns it."""
    from PIL import Image  # a tenth of a second

    if not data:
        raise InputError(f"{where}: the file is empty; copy or record it again.")
    if len(data) > _MOST_BYTES:
        raise InputError(f"{where}: the image takes more than {_MOST_BYTES >> 20} MB; store it grey, or with 8 bit.")
    with about(where):
        check_header(data)
    image, kinds, facts = None, (), ()
    with quiet_opencv(), suppress(cv2.error):
        image, kinds, facts = cv2.imdecodeWithMetadata(np.frombuffer(data, np.uint8), flags=cv2.IMREAD_UNCHANGED)
    if image is None and data.startswith(_JPEG):
        raise InputError(f"{where}: {_DAMAGED}")
    if image is None:
        raise InputError(f"{where}: not an image that OpenCV can read, or a damaged one; give a PNG, JPEG or TIFF.")
    exif, found = Image.Exif(), dict(zip(kinds, facts, strict=True))
    with suppress(Exception):  # of damaged facts, anything may be raised
        exif.load(found[cv2.IMAGE_METADATA_EXIF].tobytes())
    tag = exif.get(_ORIENTATION, 1)
    return image, tag if tag in range(1, 9) else 1


def check_header(data: bytes) -> None:
    """Refuse an image that announces more pixels than are read, and a damaged PNG, of which libpng would complain on
    stderr; what else is wrong, a decoder says."""
    from PIL import Image

    png = data.startswith(_PNG)
    try:
        with _ALONE, warnings.catch_warnings():
            warnings.filterwarnings("ignore", module=r"PIL\.")
            with Image.open(io.BytesIO(data), formats=_KINDS) as header:
                pixels = math.prod(header.size)
                if png and pixels <= MOST_PIXELS:
                    header.verify()
    except Image.DecompressionBombError:  # far more
        pixels = math.inf
    except Exception:  # of a damaged header, anything may be raised
        if png:
            raise InputError(_DAMAGED) from None
        return
    if pixels > MOST_PIXELS:
        raise InputError(f"the image claims to have more than {MOST_PIXELS} pixels, the most that are read; reduce it.")


def write_png(path: Path, image: Float[np.ndarray, "h w"]) -> None:
    """Write a grey image as 8-bit PNG, values rounded and clipped to 0..255; missing folders are made. InputError if
    the place cannot be written to."""
    make_folder(path.parent)
    write_bytes(path, cv2.imencode(".png", eight_bit(image))[1].tobytes())


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
