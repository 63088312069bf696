"""What image files announce; and that a decoder is not asked for what nobody has."""

import os
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from refusals import refused

from stereorecal.io import load_pair, load_rig
from stereorecal.io.images._image_files import announced_size

ENDINGS = [".png", ".jpg", ".tif", ".bmp", ".pgm", ".ppm", ".webp", ".jp2"]
IMAGE = np.random.default_rng(0).integers(0, 255, (70, 81, 3), np.uint8)


def encoded(ending: str, *options: int) -> bytes:
    image = IMAGE[..., 0] if ending == ".pgm" else IMAGE
    return cv2.imencode(ending, image, options)[1].tobytes()


@pytest.mark.parametrize("ending", ENDINGS)
def test_announced_size_and_damaged_headers(ending: str):
    data = encoded(ending)
    assert announced_size(data) == (81, 70)
    for length in range(64):
        announced_size(data[:length])
    for place in range(64):
        announced_size(data[:place] + b"\xff" + data[place + 1 :])


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("kind", "HI")
def test_a_tiff_of_either_byte_order(order: str, kind: str):
    tags = b"".join(
        struct.pack(f"{order}HHI{kind}{'xx' if kind == 'H' else ''}", tag, "HI".index(kind) + 3, 1, value)
        for tag, value in ((256, 81), (257, 70))
    )
    assert announced_size(struct.pack(f"{order}2sHIH", b"MM" if order == ">" else b"II", 42, 8, 2) + tags) == (81, 70)


def test_a_bitmap_from_top_to_bottom_has_a_negative_height():
    data = encoded(".bmp")
    assert announced_size(data[:22] + struct.pack("<i", -70) + data[26:]) == (81, 70)


@pytest.mark.parametrize("marker", [0xC4, 0xC8, 0xCC])
def test_markers_of_a_jpeg_that_are_no_frame(marker: int):
    data = encoded(".jpg")
    other = bytes([0xFF, marker]) + struct.pack(">H", 10) + b"\1" * 8
    assert announced_size(data[:2] + other + data[2:]) == (81, 70)


def test_an_enormous_image_is_not_decoded(tmp_path: Path):
    """It has no pixels, which a decoder would say first."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    path = tmp_path / "image.png"
    header = struct.pack(">IIBBBBB", 20_000, 20_000, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b""))
    refused(lambda: load_pair(path, tmp_path / "right.png"), "claims to be 20000x20000")


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="has no endless file")
@pytest.mark.parametrize("read", [load_rig, lambda path: load_pair(path, os.devnull)])
def test_files_without_end(read):
    refused(lambda: read("/dev/zero"), "more than")


@pytest.mark.parametrize("progressive", [0, 1])
def test_a_jpeg_with_a_trailer_is_read(tmp_path: Path, progressive: int):
    """Phones append a film or a depth map, in which markers may stand."""
    data = encoded(".jpg", cv2.IMWRITE_JPEG_PROGRESSIVE, progressive)
    path, right = tmp_path / "image.jpg", tmp_path / "right.png"
    cv2.imwrite(str(right), IMAGE)
    for trailer in (b"\0" * 100, b"\xff\xda" + b"x" * 50, data[: len(data) // 2]):
        path.write_bytes(data + trailer)
        assert load_pair(path, right).left.shape == IMAGE.shape[:2]
    for length in (len(data) - 1, len(data) // 2, 20):
        path.write_bytes(data[:length])
        refused(lambda: load_pair(path, right), "truncated")
