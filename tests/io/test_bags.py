"""Images in bags of ROS 1 and ROS 2."""

import pickle
import struct
import sys
import zlib

import cv2
import numpy as np
import pytest
from bags import write_bag
from refusals import refused

from stereorecal import CalibrationWarning, InputError
from stereorecal.io import bag_scene, open_pairs

pytest.importorskip("rosbags", reason="rosbags is not installed")
TOPICS = {"left_topic": "/left/image", "right_topic": "/right/image"}
START = 1_700_000_000_000_000_000
STEP = 50_000_000


def image(number: int, side: int) -> np.ndarray:
    return np.random.default_rng(10 * number + side).integers(0, 256, (24, 32), np.uint8)


def stamped(numbers=range(4), jitter: int = 1_000_000, right=None):
    for number in numbers:
        yield TOPICS["left_topic"], START + number * STEP, image(number, 0)
        if right is None or number in right:
            yield TOPICS["right_topic"], START + number * STEP + jitter, image(number, 1)


@pytest.mark.parametrize("ros1", [True, False], ids=["ROS 1", "ROS 2"])
@pytest.mark.parametrize("compressed", [False, True], ids=["raw", "compressed"])
def test_pairs_of_a_bag(tmp_path, ros1: bool, compressed: bool):
    path = write_bag(tmp_path / ("a.bag" if ros1 else "a"), stamped(), ros1=ros1, compressed=compressed)
    recorded = open_pairs(path, **TOPICS)
    assert (len(recorded.pairs), recorded.unpaired, recorded.stream) == (4, (), True)
    for number in (2, 0):
        pair = recorded.pairs[number]
        np.testing.assert_array_equal(pair.left, image(number, 0))
        np.testing.assert_array_equal(pair.right, image(number, 1))
    again = pickle.loads(pickle.dumps(recorded.pairs[1]))
    np.testing.assert_array_equal(again.right, image(1, 1))
    assert recorded.pairs[0].name == "/left/image 1700000000.000"


INFO = {"width": 32, "height": 24, "distortion_model": "plumb_bob", "d": [-0.2, 0.1, 0.001, -0.002, 0.0]}
INFO |= {"k": [30.0, 0, 16, 0, 31, 12, 0, 0, 1], "r": list(np.eye(3).ravel())}
LEFT = {**INFO, "p": [30.0, 0, 16, 0, 0, 30, 12, 0, 0, 0, 1, 0]}
RIGHT = {**INFO, "p": [30.0, 0, 16, -3.6, 0, 30, 12, 0, 0, 0, 1, 0]}
SIDES = [("/left/camera_info", LEFT), ("/right/camera_info", RIGHT)]


def scene_of_bag(path, topics=("/left/image", "/right/image"), **options):
    names = dict(zip(TOPICS, topics, strict=True))
    return bag_scene(path, topics, lambda sizes: tuple(open_pairs(path, **names, sizes=sizes).pairs), **options)


@pytest.mark.parametrize("ros1", [True, False], ids=["ROS 1", "ROS 2"])
def test_the_calibration_in_a_bag(tmp_path, ros1: bool):
    path = write_bag(tmp_path / ("a.bag" if ros1 else "a"), stamped(), ros1=ros1, infos=SIDES * 2)
    scene = scene_of_bag(path)
    assert (scene.rig.left.size, scene.rig.source, len(scene.pairs)) == ((32, 24), None, 4)
    np.testing.assert_allclose(scene.rig.extrinsics, [0, 0, 0, -0.12, 0, 0], atol=1e-12)
    np.testing.assert_array_equal(scene.rig.right.matrix, np.reshape(INFO["k"], (3, 3)))
    with pytest.warns(CalibrationWarning, match="0.00012 m long"):
        scene_of_bag(path, unit="mm")


@pytest.mark.parametrize(
    ("infos", "words"),
    [
        ([], "no /left/camera_info, which would be the calibration of /left/image (nor any other camera_info)"),
        (SIDES[:1], "there is no /right/camera_info, which would be the calibration of /right/image (there is /left/c"),
        ([*SIDES, ("/left/camera_info", RIGHT)], "/left/camera_info changes during the recording; give --calibration"),
        ([(topic, {**info, "width": 64}) for topic, info in SIDES], "image"),
        ([(topic, {**info, "k": [0.0] * 9}) for topic, info in SIDES], "/left/camera_info: "),
    ],
)
def test_no_calibration_in_a_bag(tmp_path, infos, words: str):
    path = write_bag(tmp_path / "a.bag", stamped(), ros1=True, infos=infos)
    refused(lambda: scene_of_bag(path), words)


def test_rectified_images_of_a_bag(tmp_path):
    """What camera_info says of the lens is not of them, unless there is none."""
    images = [(f"{topic}_rect", stamp, grey) for topic, stamp, grey in stamped()]
    topics = ("/left/image_rect", "/right/image_rect")
    raw = write_bag(tmp_path / "a.bag", images, ros1=True, infos=SIDES)
    words = "/left/image_rect has rectified images, and /left/camera_info the lens of"
    refused(lambda: scene_of_bag(raw, topics), words)
    straight = [(topic, {**info, "d": [0.0] * 5}) for topic, info in SIDES]
    assert scene_of_bag(write_bag(tmp_path / "b.bag", images, ros1=True, infos=straight), topics).rig is not None


def test_a_bag_by_one_of_its_files(tmp_path):
    path = write_bag(tmp_path / "run", stamped(), ros1=False)
    for part in (path / "metadata.yaml", next(path.glob("*.db3"))):
        assert len(open_pairs(part, **TOPICS).pairs) == 4
        refused(lambda part=part: open_pairs(part), "this is a bag; say which topics")


def test_frames_are_paired_by_time(tmp_path):
    """Those without partner are named."""
    path = write_bag(tmp_path / "a.bag", stamped(right=(0, 3)), ros1=True)
    recorded = open_pairs(path, **TOPICS)
    assert len(recorded.pairs) == 2
    assert recorded.unpaired == ("/left/image 1700000000.050", "/left/image 1700000000.100")
    np.testing.assert_array_equal(recorded.pairs[1].right, image(3, 1))
    late = write_bag(tmp_path / "late.bag", stamped(jitter=20_000_000), ros1=True)
    words = "no two frames lie within 0.0125 s of each other, the nearest 0.02 s"
    refused(lambda: open_pairs(late, **TOPICS), words)
    assert len(open_pairs(late, **TOPICS, tolerance=0.021).pairs) == 4


@pytest.mark.parametrize("encoding", ["bgr8", "bgra8", "rgb8", "rgba8", "bgr16", "bgra16", "rgb16", "rgba16"])
def test_order_of_channels(tmp_path, encoding: str):
    """Red and blue weigh as luma has it, whichever comes first."""
    grey = image(0, 0).astype(np.float64)
    colour = np.stack([grey, 0 * grey, 255 - grey, np.full_like(grey, 255)], axis=-1)  # red, green, blue, alpha
    if encoding.startswith("bgr"):
        colour = colour[..., [2, 1, 0, 3]]
    deep = encoding.endswith("16")
    pixels = (colour[..., : 4 if "a" in encoding else 3] * (257 if deep else 1)).astype(np.uint16 if deep else np.uint8)
    images = [("/left/image", START, pixels), ("/right/image", START, pixels // 2)]
    left = open_pairs(write_bag(tmp_path / "a.bag", images, ros1=True, encoding=encoding), **TOPICS).pairs[0].left
    expected = 0.299 * grey + 0.114 * (255 - grey)
    if deep:  # scaled so that the brightest is 255
        expected *= 255.0 / expected.max()
    np.testing.assert_allclose(left, expected, atol=0.6)


@pytest.mark.parametrize("encoding", ["8UC1", "mono16"])
def test_grey_images(tmp_path, encoding: str):
    deep = encoding == "mono16"
    images = [(topic, stamp, grey.astype(np.uint16) * 257 if deep else grey) for topic, stamp, grey in stamped((0,))]
    pair = open_pairs(write_bag(tmp_path / "a.bag", images, ros1=True, encoding=encoding), **TOPICS).pairs[0]
    brightest = max(image(0, 0).max(), image(0, 1).max()) if deep else 255
    np.testing.assert_allclose(pair.left, image(0, 0) * (255.0 / brightest), atol=0.01)


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_bayer(tmp_path, pattern: str):
    """An image that is all red stays darker than one that is all green, as luma has it."""
    rows, columns = np.mgrid[:24, :32]
    texture = 1.0 - 0.5 * (columns > 16)
    luma = {}
    for colour in "rgb":
        here = np.array([c == colour for c in pattern]).reshape(2, 2)[rows % 2, columns % 2]
        mosaic = (200 * here * texture).astype(np.uint8)
        images = [(topic, START, mosaic // part) for part, topic in enumerate(TOPICS.values(), 1)]
        path = write_bag(tmp_path / f"{colour}.bag", images, ros1=True, encoding=f"bayer_{pattern}8")
        luma[colour] = float(open_pairs(path, **TOPICS).pairs[0].left[4:20, 4:12].mean())
    np.testing.assert_allclose([luma[c] / 200 for c in "rgb"], [0.299, 0.587, 0.114], atol=0.02)


def test_what_is_refused(tmp_path):
    path = write_bag(tmp_path / "a.bag", stamped((0,)), ros1=True)
    wrong = {"left_topic": "/none", "right_topic": "/right/image"}
    refused(lambda: open_pairs(path, **wrong), "no images on the topic /none; choose from /left/image, /right/image.")
    refused(lambda: open_pairs(path), "this is a bag; say which topics")
    refused(lambda: open_pairs(tmp_path, **TOPICS), "neither a .bag file nor a folder with a metadata.yaml")
    refused(lambda: open_pairs(tmp_path / "none.bag", **TOPICS), "there is no such bag")
    (tmp_path / "bad.bag").write_bytes(b"#ROSBAG V2.0\nnothing")
    refused(lambda: open_pairs(tmp_path / "bad.bag", **TOPICS), "not a bag that can be read")
    odd = write_bag(tmp_path / "odd.bag", stamped((0,)), ros1=True, encoding="yuv422")
    refused(lambda: open_pairs(odd, **TOPICS).pairs[0], "the encoding yuv422 is not known")


def test_without_the_extra(tmp_path, monkeypatch):
    path = write_bag(tmp_path / "a.bag", stamped((0,)), ros1=True)
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(InputError, match=r"reading a bag needs .*pip install 'stereorecal\[bags\]'"):
        open_pairs(path, **TOPICS)


@pytest.mark.parametrize("error", [AssertionError(), KeyError("a"), MemoryError(), ValueError("a\n\n b")])
@pytest.mark.parametrize("when", ["opened", "read"])
def test_whatever_a_damaged_bag_raises(tmp_path, monkeypatch, error: Exception, when: str):
    from rosbags.highlevel import AnyReader

    def damaged(*_, **__):
        raise error

    path = write_bag(tmp_path / "a.bag", stamped((0,)), ros1=True)
    if when == "read":
        recorded = open_pairs(path, **TOPICS)
    monkeypatch.setattr(AnyReader, "deserialize", damaged)
    words = "a.bag: not a bag that can be read, or a damaged one"
    refused(lambda: recorded.pairs[0] if when == "read" else open_pairs(path, **TOPICS), words)


def test_a_compressed_image_that_claims_to_be_large(tmp_path):
    """It is refused before it is decoded."""
    png = bytearray(cv2.imencode(".png", image(0, 0))[1].tobytes())
    png[16:24] = struct.pack(">II", 20_000, 20_000)
    png[29:33] = struct.pack(">I", zlib.crc32(png[12:29]))
    large = ((topic, time, bytes(png)) for topic, time, _ in stamped((0,)))
    path = write_bag(tmp_path / "a.bag", large, ros1=True, compressed=True)
    refused(lambda: open_pairs(path, **TOPICS).pairs[0], "a.bag, /left/image", "claims to have more than 67108864")


@pytest.mark.parametrize("ros1", [True, False], ids=["ROS 1", "ROS 2"])
def test_images_that_no_one_stamped_have_the_times_of_their_recording(tmp_path, ros1: bool):
    images = [
        (topic, START + number * STEP, image(number, side))
        for number in range(3)
        for side, topic in enumerate(TOPICS.values())
    ]
    path = write_bag(tmp_path / ("a.bag" if ros1 else "a"), images, ros1=ros1, stamped=False)
    pairs = open_pairs(path, **TOPICS).pairs
    expected = [START / 1e9 + 0.005 + 0.05 * number for number in range(3)]
    assert [pair.time for pair in pairs] == pytest.approx(expected, abs=1e-6)
    np.testing.assert_array_equal(pairs[2].right, image(2, 1))
