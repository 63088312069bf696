"""load_pair and load_pairs: image formats, matching of names, bad files."""

import os
import pickle
import warnings
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal import InputError, PairingWarning
from stereorecal.io import load_pair, load_pairs, open_pairs

SIZE = (24, 16)


def texture(seed: int, size: tuple[int, int] = SIZE, dtype: type = np.uint8) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.integers(0, np.iinfo(dtype).max, size[::-1], dtype=dtype, endpoint=True)


def write(path: Path, image: np.ndarray) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), image)
    return path


@pytest.fixture
def right(tmp_path: Path) -> Path:
    return write(tmp_path / "right.png", texture(1))


@pytest.mark.parametrize("suffix", ["png", "tif", "tiff", "bmp", "pgm", "PNG"])
def test_grey_values_stay_as_they_are(tmp_path: Path, suffix: str):
    images = [texture(0), texture(1)]
    paths = [write(tmp_path / f"{side}.{suffix}", image) for side, image in zip("ab", images, strict=True)]
    pair = load_pair(*paths)
    np.testing.assert_array_equal(pair.left, images[0])
    np.testing.assert_array_equal(pair.right, images[1])
    assert pair.left.dtype == np.float32
    assert pair.name == f"a.{suffix}"
    assert pair.size == SIZE


def test_jpeg_within_its_loss(tmp_path: Path):
    smooth = [cv2.GaussianBlur(texture(i, (64, 48)), (0, 0), 3) for i in range(2)]
    paths = [tmp_path / f"{i}.jpg" for i in range(2)]
    for path, image in zip(paths, smooth, strict=True):
        assert cv2.imwrite(str(path), image, [cv2.IMWRITE_JPEG_QUALITY, 100])
    assert np.abs(load_pair(*paths).right - smooth[1]).max() <= 2


def test_colour_and_alpha_equal_grey(tmp_path: Path, right: Path):
    grey = texture(0)
    expected = load_pair(write(tmp_path / "grey.png", grey), right).left
    opaque = np.full_like(grey, 255)
    for name, planes in {
        "colour": [grey] * 3,
        "alpha": [*[grey] * 3, opaque],
        "clear": [*[grey] * 3, grey],
    }.items():
        loaded = load_pair(write(tmp_path / f"{name}.png", np.dstack(planes)), right).left
        np.testing.assert_allclose(loaded, expected, atol=1e-4, err_msg=name)


@pytest.mark.parametrize("suffix", ["png", "ppm", "bmp"])
def test_channel_order_is_that_of_opencv(tmp_path: Path, right: Path, suffix: str):
    colour = np.dstack([texture(seed) for seed in (3, 4, 5)])
    loaded = load_pair(write(tmp_path / f"colour.{suffix}", colour), right).left
    assert np.abs(loaded - cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY)).max() <= 0.51


@pytest.mark.parametrize("suffix", ["png", "tif", "pgm"])
def test_sixteen_bit_scales_both_images_alike(tmp_path: Path, suffix: str):
    left = texture(0, dtype=np.uint16)
    dim = left // 2
    pair = load_pair(write(tmp_path / f"a.{suffix}", left), write(tmp_path / f"b.{suffix}", dim))
    assert pair.left.max() == pytest.approx(255.0)
    np.testing.assert_allclose(pair.left, left * (255.0 / left.max()), rtol=1e-5)
    np.testing.assert_allclose(pair.right, dim * (255.0 / left.max()), rtol=1e-5)


def test_different_depths_are_refused(tmp_path: Path, right: Path):
    with pytest.raises(InputError, match=r"deep\.png.*uint16.*uint8"):
        load_pair(write(tmp_path / "deep.png", texture(0, dtype=np.uint16)), right)


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
    assert len(pickle.dumps(pair.resized((160, 120)))) > 100_000  # is no file any more


def test_resized_file_pair_survives_pickling(tmp_path: Path, right: Path):
    small = load_pair(write(tmp_path / "left.png", texture(0)), right).resized((12, 8))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(small)).left, small.left)


# --- which files belong together ----------------------------------------------------------------------------


def save(folder: Path, names: list[str], seed: int) -> None:
    for index, name in enumerate(names):
        write(folder / name, texture(seed + index))


def partners(pairs) -> list[tuple[str, str]]:
    return [tuple(Path(p).name for p in pair.origin[1][:2]) for pair in pairs]


@pytest.fixture(scope="module")
def linked(tmp_path_factory: pytest.TempPathFactory) -> Callable[[list[str], list[str]], tuple[Path, Path]]:
    """linked(left, right): folders of files of these names."""
    sources = [write(tmp_path_factory.mktemp("sources") / f"{side}.png", texture(side)) for side in (0, 1)]

    def make(*sides: list[str]) -> tuple[Path, Path]:
        left, right = folders = tuple(tmp_path_factory.mktemp(side) for side in ("left", "right"))
        for folder, source, names in zip(folders, sources, sides, strict=True):
            for name in names:
                (folder / name).hardlink_to(source)
        return left, right

    return make


def test_folders_with_equal_names_in_natural_order(tmp_path: Path):
    names = ["frame10.png", "frame9.png", "frame1.png"]
    save(tmp_path / "a", names, 0)
    save(tmp_path / "b", names[::-1], 10)
    (tmp_path / "a" / "times.txt").write_text("no image")
    (tmp_path / "a" / ".frame2.png").write_bytes(b"hidden")
    pairs = load_pairs(tmp_path / "a", tmp_path / "b")
    assert partners(pairs) == [(n, n) for n in ("frame1.png", "frame9.png", "frame10.png")]
    np.testing.assert_array_equal(pairs[2].left, texture(0))


def test_patterns_files_and_folders_are_one(tmp_path: Path):
    save(tmp_path / "a", ["1.png", "2.png"], 0)
    save(tmp_path / "b", ["1.png", "2.png"], 10)
    expected = [("1.png", "1.png"), ("2.png", "2.png")]
    assert partners(load_pairs(f"{tmp_path}/a/*.png", tmp_path / "b")) == expected
    assert partners(load_pairs(f"{tmp_path}/**/a/?.png", f"{tmp_path}/b/[12].png")) == expected
    assert partners(load_pairs(tmp_path / "a" / "2.png", str(tmp_path / "b" / "2.png"))) == expected[1:]


def test_a_file_whose_name_looks_like_a_pattern(tmp_path: Path):
    save(tmp_path, ["left[1].png", "right[1].png"], 0)
    assert len(load_pairs(tmp_path / "left[1].png", tmp_path / "right[1].png")) == 1


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (["left_10.png", "left_9.png"], ["right_10.png", "right_9.png"]),
        (["9_L.png", "10_L.png"], ["10_R.png", "9_R.png"]),
        (["9-l.png", "10-l.png"], ["9-r.png", "10-r.png"]),
        (["cam0_9.png", "cam0_10.png"], ["cam1_10.png", "cam1_9.png"]),
        (["Left1.png", "Left0.png"], ["Right1.png", "Right0.png"]),
        (["im0.png"], ["im1.png"]),
        (["a.png", "b.png"], ["b.jpg", "a.jpg"]),
    ],
)
def test_markers_of_the_side_are_no_part_of_the_name(linked, left: list[str], right: list[str]):
    matched = partners(load_pairs(*linked(left, right)))
    key = str.maketrans("", "", "".join({*"leftLrightRcam_-.pngjpgb"} - {"a", "b"}))
    assert sorted(a for a, _ in matched) == sorted(left)
    if left[0][0] in "ab":
        assert all(Path(a).stem == Path(b).stem for a, b in matched)
    elif "cam" in left[0] or left == ["im0.png"]:
        assert all(a[4:] == b[4:] for a, b in matched)
    else:
        assert all(a.translate(key) == b.translate(key) for a, b in matched)


def test_names_without_anything_in_common_go_by_order(linked):
    left, right = [f"{i}ns.png" for i in (15, 27, 39)], [f"{i}ns.png" for i in (16, 28, 40)]
    with pytest.warns(PairingWarning, match=r"15ns\.png: no name .* 3 pairs .* order .* with .*16ns\.png"):
        assert partners(load_pairs(*linked(left, right))) == list(zip(left, right, strict=True))
    with pytest.warns(PairingWarning):
        assert open_pairs(*linked(left, right)).by_order


def test_a_marker_may_stand_last(linked):
    left, right = ([f"{number}_{side}.png" for number in ("0010", "0011")] for side in (0, 1))
    found = open_pairs(*linked(left, right))
    assert (partners(found.pairs), found.by_order) == (list(zip(left, right, strict=True)), False)


def test_one_file_on_each_side_needs_no_warning(linked):
    assert not open_pairs(*linked(["a.png"], ["b.png"])).by_order


def test_frames_that_a_camera_lost_are_left_over(linked):
    found = open_pairs(*linked(["1.png", "2.png", "4.png"], ["2.png", "3.png", "4.png"]))
    assert partners(found.pairs) == [("2.png", "2.png"), ("4.png", "4.png")]
    assert [Path(name).name for name in found.unpaired] == ["1.png", "3.png"]


def test_a_few_equal_names_are_chance(linked):
    left, right = ([f"{i}.png" for i in range(first, first + 10)] for first in (0, 7))
    with pytest.raises(InputError, match=r"[/\\]0\.png: this image has no partner"):
        open_pairs(*linked(left, right))


def test_digits_of_different_length(linked):
    left, right = ([f"{side}{i}.png" for i in (1, 2, 10)] for side in ("left", "right"))
    assert partners(open_pairs(*linked(left, right)).pairs) == list(zip(left, right, strict=True))


def test_names_that_repeat_in_many_folders_pair_by_folder(tmp_path: Path):
    for number, scene in enumerate("abc"):
        save(tmp_path / scene, ["im0.png", "im1.png"], 2 * number)
    (tmp_path / "b" / "im1.png").unlink()
    found = open_pairs(f"{tmp_path}/*/im0.png", f"{tmp_path}/*/im1.png")
    assert [[Path(p).parent.name for p in pair.origin[1][:2]] for pair in found.pairs] == [[s, s] for s in "ac"]
    assert found.unpaired == ("b/im0.png",)


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("cam1_{:04d}", "cam2_{:04d}"),
        ("A{:d}", "B{:d}"),
        ("LEFT-{:03d}", "RIGHT-{:03d}"),
        ("right_{:d}", "left_{:d}"),  # the right camera stands first
        ("ir1_{:d}", "ir2_{:05d}"),
        ("port_{:04d}_rgb", "starboard_{:04d}_ir"),
        ("{:03d}_view7", "view12.{:03d}"),
        ("DSC{:05d}", "IMG_{:04d}"),
        ("3_{:d}", "4_{:d}"),
        ("run2_a_{:d}", "{:d}"),
        ("shot_Infrared 1_15561801{:05d}.7890", "shot_Infrared 2_15561801{:05d}.7890"),
        ("town_000000_{:06d}_leftImg8bit", "town_000000_{:06d}_rightImg8bit"),
        ("{:08d}L", "{:08d}R"),
    ],
)
@settings(max_examples=20)
@given(lost=st.lists(st.sets(st.integers(1, 12), max_size=3), min_size=2, max_size=2))
def test_frames_pair_by_the_numbers_that_vary(linked, left: str, right: str, lost: list[set[int]]):
    kept = [[number for number in range(1, 13) if number not in one] for one in lost]
    found = open_pairs(
        *linked(*([f"{name.format(n)}.png" for n in some] for name, some in zip((left, right), kept, strict=True)))
    )
    both = [number for number in kept[0] if number in kept[1]]
    assert partners(found.pairs) == [(f"{left.format(n)}.png", f"{right.format(n)}.png") for n in both]
    assert not found.by_order
    assert [Path(name).stem for name in found.unpaired] == [
        *(left.format(n) for n in kept[0] if n not in both),
        *(right.format(n) for n in kept[1] if n not in both),
    ]


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (["1_1000", "2_2000"], ["1_1003", "2_2004"]),  # frame and time
        (["2_a9f", "10_77b", "11_e"], ["2_0c1d", "10_5", "11_9911e"]),  # and what differs in length
        (["12.05", "12.5"], ["R-12.05", "R-12.5"]),  # fractions are no whole numbers
        (["s1_01", "s1_02", "s2_01"], ["s1_1_R", "s1_2_R", "s2_1_R"]),  # two that vary
        (["Foggy_L", "Dark_L"], ["Foggy_R", "Dark_R"]),
        (["left_foggy", "left_dark_street"], ["right_foggy", "right_dark_street"]),
    ],
)
def test_what_tells_the_frame_among_several_parts(linked, left: list[str], right: list[str]):
    sides = [[f"{name}.png" for name in names] for names in (left, right)]
    assert sorted(partners(load_pairs(*linked(*sides)))) == sorted(zip(*sides, strict=True))


def test_two_numbers_that_pair_otherwise_are_refused(linked):
    with pytest.raises(InputError, match=r"its partner is right_[12]\.png, by another right_[12]\.png; leave only"):
        open_pairs(*linked(["left_1_2.png", "left_2_1.png"], ["right_1.png", "right_2.png"]))


@settings(max_examples=30)
@given(kept=st.sets(st.integers(0, 11), min_size=1))
def test_each_file_gets_its_own_partner_and_a_warning_names_the_others(linked, kept: set[int]):
    left, right = [f"{i}.png" for i in sorted(kept)], [f"{i}.png" for i in range(12)]
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert partners(load_pairs(*linked(left, right))) == [(name, name) for name in left]
    assert [one.category for one in said] == [PairingWarning] * (len(kept) < 12)
    if said:
        alone = [Path(name).name for name in str(said[0].message).partition(": ")[2].rstrip(".").split(", ")]
        assert alone[:3] == [name for name in right if name not in left][:3]
        assert str(said[0].message).startswith(f"{12 - len(kept)} of {12 + len(kept)} images have no partner")


@pytest.mark.parametrize(
    ("left", "right", "said"),
    [
        (
            ["1", "2", "3"],
            ["3", "4", "5"],
            r"a/1\.png: .* only 1 have one of 3 left images \(1\.png to 3\.png\)",
        ),
        (["x", "y"], ["u", "v", "w"], r"b/w\.png: names of 2 left .* have nothing in common .* the same number"),
    ],
)
def test_names_that_pair_few_are_refused(tmp_path: Path, left: list[str], right: list[str], said: str):
    save(tmp_path / "a", [f"{n}.png" for n in left], 0)
    save(tmp_path / "b", [f"{n}.png" for n in right], 10)
    with pytest.raises(InputError, match=said):
        load_pairs(tmp_path / "a", f"{tmp_path}/b/*")


def test_limit_reads_no_more_files_than_that(tmp_path: Path):
    save(tmp_path / "a", ["1.png", "2.png"], 0)
    save(tmp_path / "b", ["1.png", "2.png"], 10)
    (tmp_path / "a" / "2.png").write_bytes(b"")
    assert partners(load_pairs(tmp_path / "a", tmp_path / "b", limit=1)) == [("1.png", "1.png")]
    with pytest.raises(InputError, match="limit of 0"):
        load_pairs(tmp_path / "a", tmp_path / "b", limit=0)


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("nothing/*.png", "no image matches"),
        ("empty", "no image matches"),
        ("nothing", "there is no such file or folder"),
        ("missing.png", "there is no such file or folder"),
    ],
)
def test_nothing_matches(tmp_path: Path, right: Path, where: str, said: str):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=rf"{where.replace('*', '[*]')}: {said}"):
        load_pairs(f"{tmp_path}/{where}", right)


# --- bad files ----------------------------------------------------------------------------------------------


def encoded(suffix: str, image: np.ndarray) -> bytes:
    return cv2.imencode(suffix, image)[1].tobytes()


def check_refused(path: Path, right: Path, capfd: pytest.CaptureFixture, words: str = "again|check|give") -> None:
    """The error is one line that names the file, and OpenCV prints nothing of its own."""
    capfd.readouterr()
    with pytest.raises(InputError, match=words) as error:
        load_pair(path, right)
    assert path.name in str(error.value)
    assert "\n" not in str(error.value)
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


def test_trailing_bytes_do_no_harm(tmp_path: Path, right: Path):
    for suffix in (".png", ".jpg"):
        path = tmp_path / f"long{suffix}"
        path.write_bytes(encoded(suffix, texture(0)) + bytes(100))
        assert load_pair(path, right).size == SIZE


def test_damaged_png(tmp_path: Path, right: Path, capfd):
    data = bytearray(encoded(".png", texture(0)))
    data[len(data) // 2] ^= 0xFF
    path = tmp_path / "damaged.png"
    path.write_bytes(data)
    check_refused(path, right, capfd, "image is truncated or damaged")


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "file is empty"), (b"hello " * 50, "not an image"), (b"\x89PNG\r\n\x1a\n", "image is truncated")],
)
def test_files_that_are_no_image(tmp_path: Path, right: Path, capfd, content: bytes, words: str):
    path = tmp_path / "file.png"
    path.write_bytes(content)
    check_refused(path, right, capfd, words)


def test_missing_file_and_folder_for_a_file(tmp_path: Path, right: Path, capfd):
    check_refused(tmp_path / "missing.png", right, capfd, "no such file")
    check_refused(tmp_path, right, capfd, "cannot be read")


def test_the_bad_right_image_is_named(tmp_path: Path, right: Path):
    with pytest.raises(InputError, match=r"missing\.png"):
        load_pair(right, tmp_path / "missing.png")


@pytest.mark.parametrize(("value", "words"), [(0, "all black"), (255, "constant"), (77, "constant")])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_images_without_content(tmp_path: Path, value: int, words: str, channels: int, dtype: type):
    good = write(tmp_path / "good.png", texture(1, dtype=dtype))
    blank = write(tmp_path / "blank.png", np.full((16, 24, channels), value, dtype))
    with pytest.raises(InputError, match=rf"blank\.png.*left.*{words}"):
        load_pair(blank, good)
    with pytest.raises(InputError, match=rf"blank\.png, right.*{words}"):
        load_pair(good, blank)


def test_different_sizes(tmp_path: Path, right: Path):
    with pytest.raises(InputError, match=r"wide\.png.*right\.png: the left image is 25x16 and the right one 24x16"):
        load_pair(write(tmp_path / "wide.png", texture(0, (25, 16))), right)


def test_one_file_for_both_sides(tmp_path: Path, right: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="both the left and the right"):
        load_pair("right.png", right)


def test_one_image_under_two_names(tmp_path: Path, right: Path):
    """The files are blamed, by name: not the calibration that they are checked against."""
    copy = write(tmp_path / "copy.png", texture(1))
    with pytest.raises(InputError, match=r"^\S*copy\.png and \S*right\.png: left and right are the same image"):
        load_pair(copy, right)


def test_floating_point_images(tmp_path: Path, right: Path):
    left = texture(0).astype(np.float32) / 255
    other = write(tmp_path / "other.tif", texture(1).astype(np.float32) / 255)
    pair = load_pair(write(tmp_path / "float.tif", left), other)
    np.testing.assert_allclose(pair.left, texture(0) * (255.0 / max(texture(0).max(), texture(1).max())), rtol=1e-4)
    left[3, 4] = np.nan
    with pytest.raises(InputError, match="NaN"):
        load_pair(write(tmp_path / "nan.tif", left), other)


def test_the_log_level_of_opencv_is_restored(tmp_path: Path, right: Path):
    level = cv2.utils.logging.getLogLevel()
    path = tmp_path / "text.png"
    path.write_text("no image")
    with pytest.raises(InputError):
        load_pair(path, right)
    assert cv2.utils.logging.getLogLevel() == level


@pytest.mark.parametrize(
    ("names", "gap"),
    [
        (["1403715273262142", "1403715273362142", "1403715273462142"], 0.1),  # microseconds: no camera is so fast
        (["1403715273262142", "1403715363262142"], 0.09),  # nanoseconds since 16 days
        (["20240501123015100", "20240501123015200", "20240501123015300"], None),  # a date with milliseconds
    ],
)
def test_what_numbers_of_16_digits_and_more_count(linked, names: list[str], gap: float | None):
    files = [f"{name}.png" for name in names]
    times = [pair.time for pair in open_pairs(*linked(files, files)).pairs]
    assert times == [None] * 3 if gap is None else np.diff(times) == pytest.approx([gap] * (len(names) - 1), abs=1e-5)


def test_names_that_are_nanoseconds_are_times(tmp_path: Path):
    """And others are not; a pair that was pickled still knows its time."""
    for name in ("1403715273262142976", "1403715273362142976"):
        for side in (0, 1):
            write(tmp_path / f"{side}" / f"{name}.png", texture(side))
    pairs = load_pairs(tmp_path / "0", tmp_path / "1")
    np.testing.assert_allclose([pair.time for pair in pairs], [1403715273.262143, 1403715273.362143], atol=1e-6)
    assert [pickle.loads(pickle.dumps(pair)).time for pair in pairs] == [pair.time for pair in pairs]
    write(tmp_path / "0" / "000003.png", texture(0))
    write(tmp_path / "1" / "000003.png", texture(1))
    assert {pair.time for pair in load_pairs(tmp_path / "0", tmp_path / "1")} == {None}
