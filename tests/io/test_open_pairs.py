"""Pairs from side-by-side images, videos and bags: the same images, paired by time, read when asked for."""

import os
import pickle
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from refusals import refused

from stereorecal import InputError, PairingWarning
from stereorecal.io import load_pairs, open_pairs

FRAMES = 6
HEIGHT, WIDTH = 48, 64


def image(number: int, side: int) -> np.ndarray:
    """Different in every frame and on either side, and soft: video codecs keep it."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    wave = np.sin(columns / (5.0 + number) + side) * np.cos(rows / 7.0)
    return (120 + 80 * wave + 5 * number).astype(np.uint8)


def write_video(path: Path, images: list[np.ndarray], rate: float = 10.0, codec: str = "MJPG") -> Path:
    height, width = images[0].shape[:2]
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), rate, (width, height))
    assert video.isOpened()
    for one in images:
        video.write(cv2.cvtColor(one, cv2.COLOR_GRAY2BGR))
    video.release()
    return path


@pytest.fixture(scope="module")
def videos(tmp_path_factory) -> tuple[Path, Path, Path]:
    """A left and a right video, and one of both side by side."""
    folder = tmp_path_factory.mktemp("videos")
    left, right = ([image(n, side) for n in range(FRAMES)] for side in (0, 1))
    both = [np.concatenate(two, axis=1) for two in zip(left, right, strict=True)]
    named = {"left": left, "right": right, "both": both}
    return tuple(write_video(folder / f"{name}.avi", images) for name, images in named.items())


def alike(found: np.ndarray, number: int, side: int) -> bool:
    return float(np.abs(found - image(number, side).astype(float)).mean()) < 4.0


@pytest.mark.parametrize("places", [(0, 1), (2,)], ids=["left and right", "side by side"])
def test_videos(videos, places):
    recorded = open_pairs(*(videos[place] for place in places))
    assert (len(recorded.pairs), recorded.unpaired, recorded.stream) == (FRAMES, (), True)
    for number in (0, 3, 1, 5):  # forwards and back
        pair = recorded.pairs[number]
        assert alike(pair.left, number, 0)
        assert alike(pair.right, number, 1)
        again = pickle.loads(pickle.dumps(pair))
        np.testing.assert_array_equal(again.left, pair.left)
        assert again.name == pair.name


@pytest.mark.skipif(os.name == "nt", reason="files that are open stay there")
def test_a_frame_with_both_sides_is_decoded_once(videos, tmp_path):
    """To go back by one, a video is opened again and searched from its beginning: that would take hours for a long
    one, and fails for one that has gone."""
    path = Path(shutil.copy(videos[2], tmp_path / "both.avi"))
    pairs = open_pairs(path).pairs
    path.unlink()
    assert len(tuple(pairs)) == FRAMES


def test_videos_of_different_length_are_paired_by_time(videos, tmp_path):
    short = write_video(tmp_path / "right.avi", [image(n, 1) for n in (0, 2, 4)], rate=5.0)
    recorded = open_pairs(videos[0], short)
    assert len(recorded.pairs) == 3
    assert alike(recorded.pairs[2].left, 4, 0)
    assert recorded.unpaired == ("left.avi 000001", "left.avi 000003", "left.avi 000005")


def test_side_by_side_images(tmp_path):
    for number in range(2):
        both = np.concatenate([image(number, 0), image(number, 1)], axis=1)
        cv2.imwrite(str(tmp_path / f"{number}.png"), both)
    recorded = open_pairs(tmp_path)
    assert not recorded.stream
    assert [pair.name for pair in recorded.pairs] == ["0.png", "1.png"]
    np.testing.assert_array_equal(recorded.pairs[1].right, image(1, 1))
    again = pickle.loads(pickle.dumps(recorded.pairs[1]))
    np.testing.assert_array_equal(again.left, image(1, 0))


def folders(folder: Path, left: list[str], right: list[str]) -> tuple[Path, Path]:
    for side, names in enumerate((left, right)):
        (folder / str(side)).mkdir()
        for number, name in enumerate(names):
            cv2.imwrite(str(folder / str(side) / f"{name}.png"), image(number, side))
    return folder / "0", folder / "1"


def test_files_by_name_as_load_pairs_does(tmp_path):
    places = folders(tmp_path, ["a", "b", "d"], ["a", "b", "c"])
    recorded = open_pairs(*places)
    with pytest.warns(PairingWarning, match="2 of 6 images have no partner"):
        loaded = load_pairs(*places)
    assert [pair.name for pair in recorded.pairs] == [pair.name for pair in loaded] == ["a.png", "b.png"]
    np.testing.assert_array_equal(recorded.pairs[1].right, loaded[1].right)
    assert recorded.unpaired == ("0/d.png", "1/c.png")  # with the folder: both may lack one of a name


def test_files_by_time(tmp_path):
    start = 1403715273262142976
    left = [str(start + step) for step in (0, 50_000_000, 100_000_000)]
    right = [str(start + step) for step in (1_000_000, 70_000_000, 101_000_000)]
    places = folders(tmp_path, left, right)
    recorded = open_pairs(*places, tolerance=0.005)
    assert [pair.name for pair in recorded.pairs] == [f"{left[0]}.png", f"{left[2]}.png"]
    assert recorded.unpaired == (f"{left[1]}.png", f"{right[1]}.png")
    assert alike(recorded.pairs[1].right, 2, 1)
    refused(lambda: open_pairs(*places, tolerance=1e-4), "no two frames lie within 0.0001 s")
    refused(lambda: open_pairs(*places, tolerance=float("nan")), "makes no sense")
    (tmp_path / "c").mkdir()
    words = "the name is not a time"
    refused(lambda: open_pairs(*folders(tmp_path / "c", ["a"], ["a"]), tolerance=0.1), words)


def test_what_is_refused(videos, tmp_path):
    left, right, both = videos
    odd, bad, cut_off = tmp_path / "odd.png", tmp_path / "bad.avi", tmp_path / "cut.avi"
    cv2.imwrite(str(odd), image(0, 0)[:, :-1])
    bad.write_bytes(b"no video at all")
    cut_off.write_bytes(both.read_bytes()[: int(0.6 * both.stat().st_size)])
    refused(lambda: open_pairs(left, tmp_path), "one is a video and the other is not")
    refused(lambda: open_pairs(tmp_path / "none.avi", right), "there is no such file")
    refused(lambda: open_pairs(bad), "not a video that OpenCV can read")
    refused(lambda: tuple(open_pairs(cut_off).pairs), "video")
    words = "right.avi: left and right come from one image, so there are no times to match; leave"
    refused(lambda: open_pairs(right, tolerance=0.1), words)
    words = "left.avi 000000 and left.avi 000000: left and right are the same image"
    refused(lambda: open_pairs(left, left).pairs[0], words)
    refused(lambda: open_pairs(left, left_topic="/left"), "both a left and a right topic")
    refused(lambda: open_pairs(odd).pairs[0], "63 pixels wide, which cannot be halved")


def test_a_video_that_claims_more_than_it_has(videos, tmp_path):
    """200 million frames in 30 kB, or frames of 81 million pixels; neither is prepared for."""
    data, path = bytearray(videos[2].read_bytes()), tmp_path / "many.avi"
    for header, place in ((b"avih", 16), (b"strh", 32)):
        start = data.index(header) + 8 + place
        data[start : start + 4] = struct.pack("<I", 200_000_000)
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"many\.avi: the video claims 200000000 frames, more than such"):
        open_pairs(path)
    path = write_video(tmp_path / "large.avi", [image(0, 0)], codec="FFV1")
    data = bytearray(path.read_bytes())
    start = data.index(b"strf") + 8 + 4
    data[start : start + 8] = struct.pack("<II", 9_000, 9_000)
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"large\.avi: frames of 9000x9000 are too large"):
        open_pairs(path)


def test_ffmpeg_says_nothing_itself(tmp_path):
    """In a process of its own: OpenCV asks once how much FFmpeg may say."""
    (tmp_path / "bad.mp4").write_bytes(b"\0\0\0\x20ftypisom" + bytes(500))
    code = "import sys, stereorecal as sr\ntry: sr.io.open_pairs(sys.argv[1])\nexcept sr.InputError: print('refused')"
    words = [sys.executable, "-c", code, tmp_path / "bad.mp4"]
    answer = subprocess.run(words, capture_output=True, text=True, check=True)
    assert (answer.stdout, answer.stderr) == ("refused\n", "")


@pytest.mark.parametrize("name", ["{}", "cam_{}"])
@pytest.mark.parametrize("start", ["1403715273262142976", "1403715273.5"])
def test_times_that_differ_a_little_pair_without_tolerance(tmp_path: Path, name: str, start: str):
    """Each camera lost another frame: by order, others would be paired."""

    def names(steps: list[float], late: float) -> list[str]:
        fraction = start.rpartition(".")[2] if "." in start else ""
        moments = [(float(start) + s + late) if fraction else int(start) + round(1e9 * (s + late)) for s in steps]
        return [name.format(f"{moment:.6f}" if fraction else moment) for moment in moments]

    left, right = names([0.0, 0.05, 0.1, 0.2], 0.0), names([0.0, 0.1, 0.15, 0.2], 0.001)
    recorded = open_pairs(*folders(tmp_path, left, right))
    assert [pair.name for pair in recorded.pairs] == [f"{left[number]}.png" for number in (0, 2, 3)]
    assert recorded.unpaired == (f"{left[1]}.png", f"{right[2]}.png")
    np.testing.assert_allclose(np.diff([pair.time for pair in recorded.pairs]), 0.1, atol=1e-5)
