"""load_pair and load_pairs: image formats, what image files announce, bad files. Which files belong together:
test_pair_names.py."""

import os
import pickle
import struct
import zlib
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import pytest
from parts_of_repairs import _image_files, check_header
from refusals import refused
from trees import SIZE, texture

from stereorecal import InputError
from stereorecal.io import load_pair, load_rig

IMAGE = np.random.default_rng(0).integers(0, 255, (70, 81, 3), np.uint8)


def write(path: Path, image: np.ndarray) -> Path:
    assert cv2.imwrite(str(path), image)
    return path


def encoded(suffix: str, image: np.ndarray = IMAGE, *options: int) -> bytes:
    image = image[..., 0] if suffix == ".pgm" and image.ndim > 2 else image
    return cv2.imencode(suffix, image, options)[1].tobytes()


@pytest.fixture
def right(tmp_path: Path) -> Path:
    return write(tmp_path / "right.png", texture(1))


@pytest.mark.parametrize("suffix", ["png", "tif", "tiff", "bmp", "pgm", "PNG"])
def test_grey_values_stay_as_they_are(tmp_path: Path, suffix: str):
    images = [texture(0), texture(1)]
    pair = load_pair(*(write(tmp_path / f"{side}.{suffix}", image) for side, image in zip("ab", images, strict=True)))
    np.testing.assert_array_equal(pair.left, images[0])
    np.testing.assert_array_equal(pair.right, images[1])
    assert (pair.left.dtype, pair.name, pair.size) == (np.float32, f"a.{suffix}", SIZE)


def test_jpeg_within_its_loss(tmp_path: Path):
    smooth = [cv2.GaussianBlur(texture(i, (64, 48)), (0, 0), 3) for i in range(2)]
    paths = [tmp_path / f"{i}.jpg" for i in range(2)]
    for path, image in zip(paths, smooth, strict=True):
        assert cv2.imwrite(str(path), image, [cv2.IMWRITE_JPEG_QUALITY, 100])
    assert np.abs(load_pair(*paths).right - smooth[1]).max() <= 2


@pytest.mark.parametrize("suffix", ["png", "ppm", "bmp"])
def test_channel_order_is_that_of_opencv(tmp_path: Path, right: Path, suffix: str):
    colour = np.dstack([texture(seed) for seed in (3, 4, 5)])
    loaded = load_pair(write(tmp_path / f"colour.{suffix}", colour), right).left
    assert np.abs(loaded - cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY)).max() <= 0.51
    transparent = np.dstack([colour, texture(6)])
    if suffix == "png":
        alpha = load_pair(write(tmp_path / "alpha.png", transparent), right).left
        np.testing.assert_allclose(alpha, loaded, atol=1e-4)


@pytest.mark.parametrize(
    ("suffix", "dtype"), [("png", np.uint16), ("tif", np.uint16), ("pgm", np.uint16), ("tif", np.float32)]
)
def test_wider_images_stay_wide_and_are_scaled_alike(tmp_path: Path, suffix: str, dtype: type):
    left = texture(0).astype(np.uint16) * 257
    sides = [(image / (65535 if dtype is np.float32 else 1)).astype(dtype) for image in (left, left // 2)]
    pair = load_pair(*(write(tmp_path / f"{i}.{suffix}", image) for i, image in enumerate(sides)))
    np.testing.assert_allclose(pair.left, left * (255.0 / left.max()), rtol=1e-5)
    np.testing.assert_allclose(pair.right, (left // 2) * (255.0 / left.max()), rtol=1e-5)


def test_file_pairs_pickle_as_their_paths(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for side in ("left", "right"):
        write(tmp_path / f"{side}.png", texture(len(side), (320, 240)))
    monkeypatch.chdir(tmp_path)
    pair = load_pair("left.png", "right.png")
    data = pickle.dumps(pair)
    assert len(data) < 1000
    monkeypatch.chdir(os.path.sep)  # another working directory, as on a worker
    again = pickle.loads(data)
    np.testing.assert_array_equal(again.left, pair.left)
    np.testing.assert_array_equal(again.right, pair.right)
    assert again.name == pair.name == "left.png"
    small = pair.resized((160, 120))
    assert len(pickle.dumps(small)) > 100_000  # is no file any more
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(small)).left, small.left)


# --- bad files ----------------------------------------------------------------------------------------------


def check_refused(path: Path, right: Path, capfd: pytest.CaptureFixture, words: str = "") -> None:
    """The error is one line that names the file, and OpenCV prints nothing of its own."""
    capfd.readouterr()
    refused(lambda: load_pair(path, right), path.name, words)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".bmp", ".pgm", ".webp"])
@pytest.mark.parametrize("colour", [False, True])
def test_truncated_images_are_refused_silently(tmp_path: Path, capfd, suffix: str, colour: bool):
    if colour and suffix == ".pgm":
        suffix = ".ppm"
    size = (60, 40)
    whole = encoded(suffix, np.dstack([texture(seed, size) for seed in range(3 if colour else 1)]))
    path, right = tmp_path / f"cut{suffix}", write(tmp_path / "right.png", texture(1, size))
    path.write_bytes(whole)
    assert load_pair(path, right).size == size
    for length in {*range(0, len(whole), max(1, len(whole) // 50)), len(whole) - 5}:
        path.write_bytes(whole[:length])
        check_refused(path, right, capfd)


def test_truncated_jpeg_with_a_whole_thumbnail(tmp_path: Path, right: Path, capfd):
    thumbnail, whole = encoded(".jpg", texture(0, (16, 8))), encoded(".jpg", texture(1))
    segment = b"\xff\xe1" + (len(thumbnail) + 8).to_bytes(2, "big") + b"Exif\x00\x00" + thumbnail
    path = tmp_path / "photo.jpg"
    path.write_bytes(whole[:2] + segment + whole[2:])
    assert load_pair(path, right).size == SIZE
    path.write_bytes(whole[:2] + segment + whole[2:-20])
    check_refused(path, right, capfd, "image is truncated")


def test_damaged_png(tmp_path: Path, right: Path, capfd):
    path = tmp_path / "image.png"
    data = bytearray(encoded(".png", texture(0)))
    path.write_bytes(data + bytes(100))  # which do no harm
    assert load_pair(path, right).size == SIZE
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)
    check_refused(path, right, capfd, "image is truncated or damaged")


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "file is empty"), (b"hello " * 50, "not an image"), (b"\x89PNG\r\n\x1a\n", "image is truncated")],
)
def test_files_that_are_no_image(tmp_path: Path, right: Path, capfd, content: bytes, words: str):
    path, level = tmp_path / "file.png", cv2.utils.logging.getLogLevel()
    path.write_bytes(content)
    check_refused(path, right, capfd, words)
    assert cv2.utils.logging.getLogLevel() == level


def test_missing_file_and_folder_for_a_file(tmp_path: Path, right: Path, capfd):
    check_refused(tmp_path / "missing.png", right, capfd, "no such file")
    check_refused(tmp_path, right, capfd, "cannot be read")
    refused(lambda: load_pair(right, tmp_path / "missing.png"), "missing.png")


def test_images_without_content(tmp_path: Path, right: Path):
    blank = write(tmp_path / "blank.png", np.full((16, 24, 3), 77, np.uint8))
    refused(lambda: load_pair(blank, right), "blank.png", ", left: ", "constant")
    refused(lambda: load_pair(right, blank), "blank.png, right: ", "constant")


def test_images_that_do_not_go_together(tmp_path: Path, right: Path, monkeypatch: pytest.MonkeyPatch):
    """The files are blamed, by name: not the calibration that they are checked against."""
    deep = write(tmp_path / "deep.png", texture(0).astype(np.uint16))
    with pytest.raises(InputError, match=r"deep\.png.*uint16.*uint8"):
        load_pair(deep, right)
    wide = write(tmp_path / "wide.png", texture(0, (25, 16)))
    with pytest.raises(InputError, match=r"wide\.png.*right\.png: the left image is 25x16 and the right one 24x16"):
        load_pair(wide, right)
    copy = write(tmp_path / "copy.png", texture(1))
    with pytest.raises(InputError, match=r"^\S*copy\.png and \S*right\.png: left and right are the same image"):
        load_pair(copy, right)
    monkeypatch.chdir(tmp_path)
    refused(lambda: load_pair("right.png", right), "both the left and the right")


# --- headers ----------------------------------------------------------------------------------------------

ENDINGS = [".png", ".jpg", ".tif", ".bmp", ".pgm", ".ppm", ".webp", ".jp2"]


def check_announced(monkeypatch: pytest.MonkeyPatch, data: bytes) -> None:
    """A header says how many pixels there are."""
    monkeypatch.setattr(_image_files, "MOST_PIXELS", 81 * 70)
    check_header(data)
    monkeypatch.setattr(_image_files, "MOST_PIXELS", 81 * 70 - 1)
    refused(lambda: check_header(data), "the image claims to have more than 5669 pixels")


@pytest.mark.parametrize("ending", ENDINGS)
def test_announced_size_and_damaged_headers(monkeypatch: pytest.MonkeyPatch, ending: str):
    data = encoded(ending)
    check_announced(monkeypatch, data)
    for place in range(64):
        for damaged in (data[:place], data[:place] + b"\xff" + data[place + 1 :]):
            with suppress(InputError):
                check_header(damaged)


def test_a_bitmap_from_top_to_bottom_has_a_negative_height(monkeypatch: pytest.MonkeyPatch):
    data = encoded(".bmp")
    check_announced(monkeypatch, data[:22] + struct.pack("<i", -70) + data[26:])


@pytest.mark.parametrize("marker", [0xC4, 0xC8, 0xCC])
def test_markers_of_a_jpeg_that_are_no_frame(monkeypatch: pytest.MonkeyPatch, marker: int):
    data = encoded(".jpg")
    other = bytes([0xFF, marker]) + struct.pack(">H", 10) + b"\1" * 8
    check_announced(monkeypatch, data[:2] + other + data[2:])


def test_an_enormous_image_is_not_decoded(tmp_path: Path):
    """It has no pixels, which a decoder would say first."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    path = tmp_path / "image.png"
    header = struct.pack(">IIBBBBB", 20_000, 20_000, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b""))
    refused(lambda: load_pair(path, tmp_path / "right.png"), "claims to have more than 67108864 pixels")


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="has no endless file")
@pytest.mark.parametrize("read", [load_rig, lambda path: load_pair(path, os.devnull)])
def test_files_without_end(read):
    refused(lambda: read("/dev/zero"), "more than")


@pytest.mark.parametrize("progressive", [0, 1])
def test_a_jpeg_with_a_trailer_is_read(tmp_path: Path, progressive: int):
    """Phones append a film or a depth map, in which markers may stand."""
    data = encoded(".jpg", IMAGE, cv2.IMWRITE_JPEG_PROGRESSIVE, progressive)
    path, right = tmp_path / "image.jpg", tmp_path / "right.png"
    cv2.imwrite(str(right), IMAGE)
    for trailer in (b"\0" * 100, b"\xff\xda" + b"x" * 50, data[: len(data) // 2]):
        path.write_bytes(data + trailer)
        assert load_pair(path, right).left.shape == IMAGE.shape[:2]
    for length in (len(data) - 1, len(data) // 2, 20):
        path.write_bytes(data[:length])
        refused(lambda: load_pair(path, right), "truncated")
