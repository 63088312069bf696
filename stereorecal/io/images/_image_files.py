"""Image files: finding, decoding and writing them; the size that a header announces, before a decoder reserves memory
for it; and how an image is turned."""

import re
import struct
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float, Num

from stereorecal._errors import InputError
from stereorecal.io._atomic import make_folder, write_bytes
from stereorecal.io._read_files import note_input

Pixels = Num[np.ndarray, "..."]
_PNG, _JPEG = b"\x89PNG", b"\xff\xd8"
# JPEG: the markers of a frame's header (not C4, C8 and CC), and those that do not stand alone within data.
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
_IN_DATA = re.compile(rb"\xff+[^\x00\xd0-\xd7\xff]", re.DOTALL)
_WIDTH, _HEIGHT, _ORIENTATION = 256, 257, 274  # tags of a TIFF, and of EXIF


def announced_size(data: bytes) -> tuple[int, int] | None:
    """(width, height) as the header says; None if it does not, or the kind of file is not known here."""
    try:
        if data.startswith(_PNG):
            return struct.unpack(">II", data[16:24])
        if data.startswith(_JPEG):
            found = _IN_DATA.search(data, 2)
            while found is not None and found[0][-1] not in _FRAMES:
                found = _IN_DATA.search(data, found.end() + int.from_bytes(data[found.end() : found.end() + 2], "big"))
            height, width = (0, 0) if found is None else struct.unpack_from(">HH", data, found.end() + 3)
            return None if found is None else (width, height)
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
        match data[8:16]:
            case b"WEBPVP8X":
                return int.from_bytes(data[24:27], "little") + 1, int.from_bytes(data[27:30], "little") + 1
            case b"WEBPVP8L":
                bits = int.from_bytes(data[21:25], "little")
                return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
            case b"WEBPVP8 ":
                width, height = struct.unpack_from("<HH", data, 26)
                return width & 0x3FFF, height & 0x3FFF
    except (struct.error, ValueError, IndexError):
        pass
    return None


def _is_whole(png: bytes) -> bool:
    """Whether a PNG is complete and undamaged, of which libpng would complain on stderr."""
    start = 8
    while start + 12 <= len(png):
        end = start + 8 + int.from_bytes(png[start : start + 4], "big")
        if zlib.crc32(png[start + 4 : end]) != int.from_bytes(png[end : end + 4], "big"):
            return False
        if png[start + 4 : start + 8] == b"IEND":
            return True
        start = end + 4
    return False


def _tags(data: bytes) -> dict[int, int]:
    """The tags of a TIFF that are needed here."""
    order = "<" if data[:2] == b"II" else ">"
    (first,) = struct.unpack_from(f"{order}I", data, 4)
    (count,) = struct.unpack_from(f"{order}H", data, first)
    found = {}
    for start in range(first + 2, first + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from(f"{order}HH", data, start)
        if tag in (_WIDTH, _HEIGHT, _ORIENTATION):
            (found[tag],) = struct.unpack_from(f"{order}{'H' if kind == 3 else 'I'}", data, start + 8)
    return found


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
    try:
        with open(path, "rb") as file:
            return file.read(_MOST_BYTES + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; check the path.") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the file.") from error


def decode_image(data: bytes, where: str) -> tuple[Pixels, int]:
    """What `read_image` gives, of what an image file holds; a TIFF has orientation 1, since OpenCV always turns it."""
    if not data:
        raise InputError(f"{where}: the file is empty; copy or record it again.")
    width, height = announced_size(data) or (0, 0)
    if width * height > MOST_PIXELS:
        raise InputError(f"{where}: the image claims to be {width}x{height}; at most {MOST_PIXELS} pixels are read.")
    if len(data) > _MOST_BYTES:
        raise InputError(f"{where}: the image takes more than {_MOST_BYTES >> 20} MB; store it grey, or with 8 bit.")
    image, kinds, facts, damaged = None, (), (), data.startswith(_PNG) and not _is_whole(data)
    with quiet_opencv(), suppress(cv2.error):
        if not damaged:
            image, kinds, facts = cv2.imdecodeWithMetadata(np.frombuffer(data, np.uint8), flags=cv2.IMREAD_UNCHANGED)
    if damaged or (image is None and data.startswith(_JPEG)):
        raise InputError(f"{where}: the image is truncated or damaged; copy or record it again.")
    if image is None:
        raise InputError(f"{where}: not an image that OpenCV can read, or a damaged one; give a PNG, JPEG or TIFF.")
    exif = [fact.tobytes() for kind, fact in zip(kinds, facts, strict=True) if kind == cv2.IMAGE_METADATA_EXIF]
    try:
        tag = _tags(exif[0].removeprefix(b"Exif\0\0")).get(_ORIENTATION, 1) if exif else 1
    except struct.error:
        tag = 1
    return image, tag if tag in range(1, 9) else 1


def write_png(path: Path, image: Float[np.ndarray, "h w"]) -> None:
    """Write a grey image as 8-bit PNG, values rounded and clipped to 0..255; missing folders are made. InputError if
    the place cannot be written to."""
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
