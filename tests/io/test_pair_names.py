"""Which image files belong together, by their names, and which times these are."""

import pickle
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from refusals import refused
from trees import texture, write_image

from stereorecal import InputError, PairingWarning
from stereorecal.io import load_pairs, open_pairs


def save(folder: Path, names: list[str], seed: int) -> None:
    for index, name in enumerate(names):
        write_image(folder / name, seed + index)


def partners(pairs) -> list[tuple[str, str]]:
    return [tuple(Path(p).name for p in pair.origin[1][:2]) for pair in pairs]


@pytest.fixture(scope="module")
def linked(tmp_path_factory: pytest.TempPathFactory) -> Callable[[list[str], list[str]], tuple[Path, Path]]:
    """linked(left, right): folders of files of these names."""
    sources = [write_image(tmp_path_factory.mktemp("sources") / f"{side}.png", side) for side in (0, 1)]

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
    save(tmp_path / "a", ["1.png", "2.png", "left[1].png"], 0)
    save(tmp_path / "b", ["1.png", "2.png", "right[1].png"], 10)
    expected = [("1.png", "1.png"), ("2.png", "2.png")]
    assert partners(load_pairs(f"{tmp_path}/a/?.png", f"{tmp_path}/b/?.png")) == expected
    assert partners(load_pairs(f"{tmp_path}/**/a/?.png", f"{tmp_path}/b/[12].png")) == expected
    assert partners(load_pairs(tmp_path / "a" / "2.png", str(tmp_path / "b" / "2.png"))) == expected[1:]
    assert len(load_pairs(tmp_path / "a/left[1].png", tmp_path / "b/right[1].png")) == 1


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("left_{}", "right_{}"),
        ("{}_L", "{}_R"),
        ("{}-l", "{}-r"),
        ("cam0_{}", "cam1_{}"),
        ("Left{}", "Right{}"),
        ("im0", "im1"),
        ("{}_0", "{}_1"),  # a marker may stand last
    ],
)
@pytest.mark.parametrize("numbers", [("9", "10"), ("0010", "0011"), ("1", "2", "10")])
def test_markers_of_the_side_are_no_part_of_the_name(linked, left: str, right: str, numbers: tuple[str, ...]):
    sides = [list(dict.fromkeys(f"{name.format(n)}.png" for n in numbers)) for name in (left, right)]
    found = open_pairs(*linked(sides[0][::-1], sides[1]))
    assert sorted(partners(found.pairs)) == sorted(zip(*sides, strict=True))
    assert not found.by_order


def test_endings_are_no_part_of_the_name(linked):
    found = open_pairs(*linked(["a.png", "b.png"], ["b.jpg", "a.jpg"]))
    assert partners(found.pairs) == [("a.png", "a.jpg"), ("b.png", "b.jpg")]
    assert not open_pairs(*linked(["a.png"], ["b.png"])).by_order  # one on each side needs no warning


def test_names_without_anything_in_common_go_by_order(linked):
    left, right = [f"{i}ns.png" for i in (15, 27, 39)], [f"{i}ns.png" for i in (16, 28, 40)]
    with pytest.warns(PairingWarning, match=r"15ns\.png: no name .* 3 pairs .* order .* with .*16ns\.png"):
        found = open_pairs(*linked(left, right))
    assert partners(found.pairs) == list(zip(left, right, strict=True))
    assert found.by_order


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
@settings(max_examples=settings.default.max_examples // 5)
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
        (["1", "2", "3"], ["3", "4", "5"], r"/1\.png: .* only 1 have one of 3 left images \(1\.png to 3\.png\)"),
        (["x", "y"], ["u", "v", "w"], r"/w\.png: names of 2 left .* have nothing in common .* the same number"),
        ([*map(str, range(10))], [*map(str, range(7, 17))], r"[/\\]0\.png: this image has no partner"),  # by chance
        (["left_1_2", "left_2_1"], ["right_1", "right_2"], r"its partner is right_[12]\.png, by another right_[12]\."),
    ],
)
def test_names_that_tell_too_little_are_refused(linked, left: list[str], right: list[str], said: str):
    with pytest.raises(InputError, match=said):
        load_pairs(*linked(*([f"{name}.png" for name in names] for names in (left, right))))


def test_limit_reads_no_more_files_than_that(tmp_path: Path):
    save(tmp_path / "a", ["1.png", "2.png"], 0)
    save(tmp_path / "b", ["1.png", "2.png"], 10)
    (tmp_path / "a" / "2.png").write_bytes(b"")
    assert partners(load_pairs(tmp_path / "a", tmp_path / "b", limit=1)) == [("1.png", "1.png")]
    refused(lambda: load_pairs(tmp_path / "a", tmp_path / "b", limit=0), "limit of 0")


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("nothing/*.png", "no image matches"),
        ("empty", "no image matches"),
        ("missing.png", "there is no such file or folder"),
    ],
)
def test_nothing_matches(tmp_path: Path, where: str, said: str):
    (tmp_path / "empty").mkdir()
    refused(lambda: load_pairs(f"{tmp_path}/{where}", write_image(tmp_path / "right.png", 1)), f"{where}: {said}")


# --- times --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("names", "gap"),
    [
        (["1403715273262142", "1403715273362142", "1403715273462142"], 0.1),  # microseconds: no camera is so fast
        (["1403715273262142", "1403715363262142"], 0.09),  # nanoseconds since 16 days
        (["20240501123015100", "20240501123015200", "20240501123015300"], None),  # a date with milliseconds
        (["1403715273262142976", "1403715273362142976", "000003"], None),
    ],
)
def test_what_numbers_of_16_digits_and_more_count(linked, names: list[str], gap: float | None):
    files = [f"{name}.png" for name in names]
    times = [pair.time for pair in open_pairs(*linked(files, files)).pairs]
    assert times == [None] * 3 if gap is None else np.diff(times) == pytest.approx([gap] * (len(names) - 1), abs=1e-5)


def test_names_that_are_nanoseconds_are_times(linked):
    """A pair that was pickled still knows its own."""
    names = ["1403715273262142976.png", "1403715273362142976.png"]
    pairs = load_pairs(*linked(names, names))
    np.testing.assert_allclose([pair.time for pair in pairs], [1403715273.262143, 1403715273.362143], atol=1e-6)
    assert [pickle.loads(pickle.dumps(pair)).time for pair in pairs] == [pair.time for pair in pairs]
