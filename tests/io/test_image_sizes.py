"""Images that are not as the calibration has them: turned by an EXIF orientation, or of two sizes."""

import pickle
import struct
import warnings
import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from gathered import gathered
from parts_of_repairs import decode_image
from refusals import refused

import stereorecal as sr
from stereorecal import CalibrationWarning, InputError
from stereorecal.io import load_log, load_pair, load_rig, load_scene, open_pairs, save_rig

SMALL, LARGE = (96, 64), (144, 128)
_LENS = np.array([-0.2, 0.05, 0.0, 0.0])
_RIG = sr.synthetic.default_rig().resized(SMALL)
RIG = replace(_RIG, left=replace(_RIG.left, distortion=_LENS), right=replace(_RIG.right, distortion=_LENS))
TWO = replace(RIG, right=RIG.right.resized(LARGE))


def exif(tag: int, order: str = "<") -> bytes:
    head = b"II" if order == "<" else b"MM"
    return head + struct.pack(f"{order}HIHHHIHHI", 42, 8, 1, 0x0112, 3, 1, tag, 0, 0)


def tagged(image: np.ndarray, tag: int, ending: str = ".jpg", order: str = "<") -> bytes:
    """An image file with an EXIF orientation."""
    data, facts = cv2.imencode(ending, image)[1].tobytes(), exif(tag, order)
    match ending:
        case ".jpg":
            body = b"Exif\0\0" + facts
            return data[:2] + b"\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body + data[2:]
        case ".png":
            chunk = b"eXIf" + facts
            return data[:33] + struct.pack(">I", len(facts)) + chunk + struct.pack(">I", zlib.crc32(chunk)) + data[33:]
        case _:
            kinds, facts = [cv2.IMAGE_METADATA_EXIF], [np.frombuffer(facts, np.uint8)]
            return cv2.imencodeWithMetadata(ending, image, kinds, facts)[1].tobytes()


def stored(image: np.ndarray, tag: int) -> np.ndarray:
    """The pixels that an orientation turns to an image."""
    shown = [lambda i: i, np.fliplr, lambda i: np.rot90(i, 2), np.flipud]
    shown += [np.transpose, lambda i: np.rot90(i, 1), lambda i: np.rot90(i.T, 2), lambda i: np.rot90(i, -1)]
    return np.ascontiguousarray(shown[tag - 1](image))


def picture(seed: int, size: tuple[int, int] = SMALL) -> np.ndarray:
    """Smooth: it is the same after resampling, and after JPEG."""
    rng = np.random.default_rng(seed)
    return cv2.resize(rng.integers(0, 255, (6, 8), np.uint8), size, interpolation=cv2.INTER_CUBIC)


def write_sides(folder: Path, tags: Sequence[int], ending: str = ".png") -> tuple[Path, Path]:
    folder.mkdir(exist_ok=True)
    paths = folder / f"left{ending}", folder / f"right{ending}"
    for seed, (path, tag) in enumerate(zip(paths, tags, strict=True)):
        path.write_bytes(tagged(stored(picture(seed), tag), tag, ending))
    return paths


def said(call, *arguments, **options):
    """What a call returns, and what it warns of."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        result = call(*arguments, **options)
    assert all(each.category is CalibrationWarning for each in found)
    return result, [str(each.message) for each in found]


@pytest.mark.parametrize("ending", [".jpg", ".png", ".webp"])
@pytest.mark.parametrize("order", "<>")
def test_orientations_are_found(ending: str, order: str):
    image = picture(0)
    assert decode_image(cv2.imencode(ending, image)[1].tobytes(), "")[1] == 1
    for tag in (*range(1, 9), 0, 9, 65535):
        assert decode_image(tagged(image, tag, ending, order), "")[1] == (tag if tag in range(1, 9) else 1)
    whole = tagged(image, 6, ending, order)
    for length in range(1, len(whole) - 1, 7):
        refused(lambda length=length: decode_image(whole[:length], "a"), "a: ", "damaged")


@pytest.mark.parametrize("tag", range(2, 9))
def test_a_turned_image_is_as_opencv_reads_it_where_only_that_fits(tmp_path: Path, tag: int):
    """Left upright, right turned: sizes tell nothing of 180 degrees and of mirrors, and pixels are used as stored."""
    paths = write_sides(tmp_path, (1, tag))
    pair, words = said(load_pair, *paths)
    expected = cv2.imread(str(paths[1]), cv2.IMREAD_GRAYSCALE) if tag > 4 else stored(picture(1), tag)
    np.testing.assert_array_equal(pair.right, expected)
    np.testing.assert_array_equal(pair.left, picture(0))
    done = "applied, since" if tag > 4 else "not applied; the cal"
    assert len(words) == 1
    assert f"right.png: EXIF orientations 1 and {tag} {done}" in words[0]
    again, words = said(lambda: pickle.loads(pickle.dumps(pair)))
    np.testing.assert_array_equal(again.right, pair.right)
    assert words == []  # once is enough


@pytest.mark.parametrize(("tag", "turned"), [(1, None), (3, False), (6, True), (8, True)])
def test_a_scene_folder_whose_images_have_orientations(tmp_path: Path, tag: int, turned: bool | None):
    folder = tmp_path / "scene"
    paths = write_sides(folder, (tag, tag))
    save_rig(RIG, folder / "calib.json")
    scene, words = said(load_scene, folder)
    assert scene.pairs[0].size == SMALL
    np.testing.assert_array_equal(scene.pairs[0].left, stored(picture(0), tag) if turned is False else picture(0))
    assert len(words) == (turned is not None)
    if words:
        assert words[0].startswith(f"{folder / 'left.png'}: ")
        assert f"EXIF orientation {tag} {'' if turned else 'not '}applied" in words[0]
        assert ("the calibration may be for turned images" in words[0]) is not turned
    scene, again = said(gathered, *paths, folder / "calib.json")
    np.testing.assert_array_equal(scene.pairs[0].right, stored(picture(1), tag) if turned is False else picture(1))
    assert again == words


def test_images_that_are_turned_without_saying_so_are_refused(tmp_path: Path):
    folder = tmp_path / "scene"
    folder.mkdir()
    for seed, side in enumerate(("left", "right")):
        cv2.imwrite(str(folder / f"{side}.png"), picture(seed).T)
    save_rig(RIG, folder / "calib.json")
    with pytest.raises(InputError, match=r"left\.png: the images are 64x96, but .* 96x64; .* turned by 90 degrees"):
        load_scene(folder)


def two_sizes(folder: Path) -> tuple[Path, Path]:
    folder.mkdir(exist_ok=True)
    cv2.imwrite(str(folder / "left.png"), picture(0))
    cv2.imwrite(str(folder / "right.png"), picture(1, LARGE))
    return folder / "left.png", folder / "right.png"


@pytest.mark.parametrize(
    ("format", "names"), [("kalibr", ["chain.yaml"]), ("basalt", ["c.json"]), ("ros", ["l.yaml", "r.yaml"])]
)
def test_the_larger_images_are_read_at_the_smaller_size(tmp_path: Path, format: str, names: list[str]):
    files, out = [tmp_path / name for name in names], [tmp_path / f"out_{name}" for name in names]
    save_rig(TWO, files, format=format)
    scene, words = said(gathered, *two_sizes(tmp_path), files[0] if len(files) == 1 else tuple(files), unit="m")
    (pair,), rig = scene.pairs, scene.rig
    assert rig is not None
    assert rig.left.size == rig.right.size == pair.size == SMALL
    assert np.abs(pair.right - picture(1)).mean() < 3.0
    assert [f"{' and '.join(map(str, files))}: the images are 96x64 (left) and 144x128 (right); the larger"] == [
        word.partition(" are read")[0] for word in words
    ]
    np.testing.assert_allclose(rig.right.matrix, RIG.right.matrix, rtol=1e-12)
    save_rig(rig, out)
    assert [path.read_bytes() for path in out] == [path.read_bytes() for path in files]
    longer = replace(rig.right, matrix=rig.right.matrix * [[1.01], [1.0], [1.0]])
    turned = replace(rig, right=longer).with_extrinsics(rig.extrinsics + 0.001)
    save_rig(turned, out, overwrite=True)
    again, _ = said(load_rig, out, unit="m")
    assert (again.left.size, again.right.size) == (SMALL, LARGE)
    np.testing.assert_allclose(again.extrinsics, turned.extrinsics, atol=1e-12)
    np.testing.assert_array_equal(again.left.matrix, RIG.left.matrix)
    np.testing.assert_allclose(again.right.resized(SMALL).matrix, longer.matrix, rtol=1e-12)


def test_a_folder_of_cameras_of_two_sizes(tmp_path: Path):
    """EuRoC's layout."""
    for number, camera in enumerate((TWO.left, TWO.right)):
        place = tmp_path / f"mav0/cam{number}"
        (place / "data").mkdir(parents=True)
        cv2.imwrite(str(place / "data" / f"{10**18}.png"), picture(number, camera.size))
    save_rig(TWO, [tmp_path / f"mav0/cam{number}/sensor.yaml" for number in (0, 1)], format="euroc")
    log, words = said(load_log, tmp_path)
    assert log.missions[0].pairs[0].size == log.calibrations["stored"].right.size == SMALL
    assert len(words) == 1


def test_sizes_that_are_not_those_of_the_cameras_are_refused(tmp_path: Path):
    left, right = two_sizes(tmp_path)
    save_rig(TWO, tmp_path / "chain.yaml", format="kalibr")
    cv2.imwrite(str(tmp_path / "small.png"), picture(1))
    for one, other, found in ((right, left, "144x128 .left. and"), (left, tmp_path / "small.png", "96x64 .left. and")):
        with pytest.raises(InputError, match=rf"are {found} 96x64 .right., but .* for 96x64 .left. and 144x128"):
            gathered(one, other, tmp_path / "chain.yaml")
    for rig, name, format in ((RIG, "one.yaml", "kalibr"), (RIG, "calib.json", None)):
        save_rig(rig, tmp_path / name, format=format)
        with pytest.raises(InputError, match=r"both must have the same size, or each that of its camera"):
            gathered(left, right, tmp_path / name)


def test_videos_of_two_sizes(tmp_path: Path):
    for seed, (side, size) in enumerate({"left": SMALL, "right": LARGE}.items()):
        video = cv2.VideoWriter(str(tmp_path / f"{side}.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, size)
        for _ in range(2):
            video.write(cv2.cvtColor(picture(seed, size), cv2.COLOR_GRAY2BGR))
        video.release()
    recorded = open_pairs(tmp_path / "left.avi", tmp_path / "right.avi", sizes=(SMALL, LARGE))
    assert pickle.loads(pickle.dumps(recorded.pairs[1])).size == SMALL
