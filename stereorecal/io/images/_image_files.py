"""Image files: finding, decoding (strictly) and writing them; and their headers, which say the size before a decoder
reserves memory for it, how the image is turned, and whether the file is complete."""

import re
import struct
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
from jaxtyping import Float, Num

from stereorecal._errors import InputError
from stereorecal.io._atomic import make_folder, write_bytes
from stereorecal.io._read_files import note_input

_PNG, _JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8"
# JPEG: the markers of a frame's header (not C4, C8 and CC), and those that stand alone within data.
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
_SCAN, _END = 0xDA, 0xD9
_WIDTH, _HEIGHT, _DEPTH, _SAMPLES, _ORIENTATION = 256, 257, 258, 277, 274  # tags of a TIFF, and of EXIF
_EXIF = b"Exif\0\0"
_IN_DATA = re.compile(rb"\xff+[^\x00\xd0-\xd7\xff]", re.DOTALL)


def announced_size(data: bytes) -> tuple[int, int] | None:
    """(width, height) as the header says; None if it does not, or the kind of file is not known here."""
    try:
        if data.startswith(_PNG):
            return struct.unpack(">II", data[16:24])
        if data.startswith(_JPEG):
            at = next((at for marker, at in _segments(data) if marker in _FRAMES), None)
            height, width = (0, 0) if at is None else struct.unpack_from(">HH", data, at + 3)
            return None if at is None else (width, height)
        if data.startswith(b"BM"):
            width, height = struct.unpack("<ii", data[18:26])
            return abs(width), abs(height)
        if data[:2] in (b"P2", b"P3", b"P5", b"P6"):
            words = re.sub(rb"#[^\n]*", b"", data[2:1024]).split(maxsplit=2)
            return int(words[0][:9]), int(words[1][:9])
        if data[:4] in (b"II*\0", b"MM\0*"):
            found = _tags(data)
            return (found[_WIDTH], found[_HEIGHT]) if _WIDTH in found and _HEIGHT in found else None
        if data[4:12] == b"jP  \r\n\x87\n":
            height, width = struct.unpack_from(">II", data, data.index(b"ihdr") + 4)
            return width, height
        if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
            return _of_webp(data)
    except (struct.error, ValueError, IndexError):
        pass
    return None


def bytes_per_pixel(data: bytes) -> int:
    """Bytes of the decoded image, where a PNG or TIFF says it; else those of colour in 8 bit."""
    try:
        if data.startswith(_PNG):
            depth, kind = data[24], data[25]
            return {0: 1, 2: 3, 3: 4, 4: 4, 6: 4}.get(kind, 4) * (2 if depth == 16 else 1)
        if data[:4] in (b"II*\0", b"MM\0*"):
            tags, order = _tags(data), "little" if data[:2] == b"II" else "big"
            samples, depth = tags.get(_SAMPLES, 1), tags.get(_DEPTH, 8)
            if samples > 2:  # their depths do not fit into the tag, which says where they are
                depth = int.from_bytes(data[depth : depth + 2], order)
            return samples * -(-depth // 8)
    except (struct.error, IndexError):
        pass
    return 3


def orientation(data: bytes) -> int:
    """EXIF's, 1 to 8, of a PNG, JPEG or WebP; 1 where none is stated, and for a TIFF, which OpenCV always turns."""
    try:
        found = _tags(exif).get(_ORIENTATION, 1) if (exif := _exif(data)) else 1
    except (struct.error, IndexError):
        found = 1
    return found if found in range(1, 9) else 1


def _exif(data: bytes) -> bytes:
    if data.startswith(_JPEG):
        places = (at for marker, at in _segments(data) if marker == 0xE1 and data[at + 2 : at + 8] == _EXIF)
        at = next(places, None)
        return b"" if at is None else data[at + 8 : at + int.from_bytes(data[at : at + 2], "big")]
    if data.startswith(_PNG):
        return _chunk(data, 8, b"eXIf", "big")
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return _chunk(data, 12, b"EXIF", "little").removeprefix(_EXIF)
    return b""


def _chunk(data: bytes, start: int, wanted: bytes, order: Literal["big", "little"]) -> bytes:
    """The content of a named part of a PNG (length, name, content, sum) or a RIFF (name, length, content, padding)."""
    while start + 8 <= len(data):
        parts = data[start : start + 4], data[start + 4 : start + 8]
        length, name = parts if order == "big" else parts[::-1]
        size = int.from_bytes(length, order)
        if name == wanted:
            return data[start + 8 : start + 8 + size]
        start += 8 + size + (4 if order == "big" else size % 2)
    return b""


def ends_properly(data: bytes) -> bool:
    """Whether a PNG or JPEG is complete: a decoder may fill the missing part with grey. True for other formats."""
    if data.startswith(_PNG):
        return _png_is_whole(data)
    if data.startswith(_JPEG):
        markers = [marker for marker, _ in _segments(data)]
        return markers[-1:] == [_END] and _SCAN in markers
    return True


def _png_is_whole(data: bytes) -> bool:
    start = 8
    while start + 12 <= len(data):
        end = start + 8 + int.from_bytes(data[start : start + 4], "big")
        if zlib.crc32(data[start + 4 : end]) != int.from_bytes(data[end : end + 4], "big"):
            return False
        if data[start + 4 : start + 8] == b"IEND":
            return True
        start = end + 4
    return False


def _segments(data: bytes) -> Iterator[tuple[int, int]]:
    """The markers of a JPEG and where what they say begins, up to the end of the image: cameras append what they like
    after it."""
    found = _IN_DATA.search(data, 2)
    while found is not None:
        marker, start = found[0][-1], found.end()
        yield marker, start
        if marker == _END:
            return
        found = _IN_DATA.search(data, start + int.from_bytes(data[start : start + 2], "big"))


def _tags(data: bytes) -> dict[int, int]:
    """The tags of a TIFF that are needed here."""
    order = "<" if data[:2] == b"II" else ">"
    (first,) = struct.unpack_from(f"{order}I", data, 4)
    (count,) = struct.unpack_from(f"{order}H", data, first)
    found = {}
    for start in range(first + 2, first + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from(f"{order}HH", data, start)
        if tag in (_WIDTH, _HEIGHT, _DEPTH, _SAMPLES, _ORIENTATION):
            count_at = struct.unpack_from(f"{order}I", data, start + 4)[0]
            short = kind == 3 and count_at <= 2
            (found[tag],) = struct.unpack_from(f"{order}{'H' if short else 'I'}", data, start + 8)
    return found


def _of_webp(data: bytes) -> tuple[int, int] | None:
    match data[12:16]:
        case b"VP8X":
            return int.from_bytes(data[24:27], "little") + 1, int.from_bytes(data[27:30], "little") + 1
        case b"VP8L":
            bits = int.from_bytes(data[21:25], "little")
            return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
        case b"VP8 ":
            width, height = struct.unpack_from("<HH", data, 26)
            return width & 0x3FFF, height & 0x3FFF
    return None


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
