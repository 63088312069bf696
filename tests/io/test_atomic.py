"""Writing files whole or not at all."""

import os
from pathlib import Path

import pytest
from machine import at_call, full_disk, raising
from refusals import refused

from stereorecal import InputError
from stereorecal.io import make_folder, write_bytes, write_files, write_text


def test_writes_and_replaces(tmp_path: Path):
    path = tmp_path / "a.json"
    write_text(path, "größer")
    assert path.read_bytes() == "größer".encode()
    write_bytes(str(path), b"new")
    assert path.read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["a.json"]


@pytest.mark.parametrize("function", ["fsync", "replace"])
@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, OSError(28, "No space left on device")])
def test_an_interrupted_write_leaves_the_old_file(tmp_path: Path, function: str, error):
    path = tmp_path / "a.json"
    path.write_text("old")
    with at_call(function, raising(error)), pytest.raises(InputError if isinstance(error, OSError) else error):
        write_text(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.json"]


def test_permissions_are_those_of_any_new_file_and_stay(tmp_path: Path):
    path, other = tmp_path / "a", tmp_path / "b"
    write_text(path, "x")
    other.write_text("x")
    assert path.stat().st_mode == other.stat().st_mode
    path.chmod(0o640)
    write_text(path, "y")
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_link_stays_a_link(tmp_path: Path):
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to("target")
    write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "new"


def test_devices_are_written_to_not_replaced():
    null = Path(os.devnull)
    write_text(null, "x")
    assert not null.is_file()


def test_bad_places(tmp_path: Path):
    (tmp_path / "file").write_text("x")
    for place in (tmp_path / "missing" / "a.json", tmp_path / "file" / "a.json", tmp_path):
        refused(lambda place=place: write_text(place, "x"), f"{place}: cannot be written")
    refused(lambda: make_folder(tmp_path / "file" / "sub"), "cannot become a folder")


def test_a_file_that_somebody_else_makes_meanwhile(tmp_path: Path):
    path = tmp_path / "a.json"
    with at_call("fsync", lambda _: path.write_text("theirs")):
        refused(lambda: write_text(path, "mine", replace=False), "a.json: the file exists already")
    assert path.read_text() == "theirs"
    assert os.listdir(tmp_path) == ["a.json"]


def test_the_longest_names_and_what_is_no_text(tmp_path: Path):
    """As a page shows a folder whose name is not UTF-8."""
    for name in ("a" * 255, "ä" * 127):
        write_text(tmp_path / name, os.fsdecode(b"bad\xff"))
        assert (tmp_path / name).read_text() == "bad\\udcff"


def test_no_room_for_the_second_of_two_files_that_belong_together(tmp_path: Path):
    left, right = tmp_path / "left", tmp_path / "right"
    left.write_text("old")
    with full_disk(nth=2):
        refused(lambda: write_files({left: b"new", right: b"new"}), "right: cannot be written")
    assert (left.read_text(), os.listdir(tmp_path)) == ("old", ["left"])


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
def test_the_owner_stays(tmp_path: Path):
    path = tmp_path / "a"
    path.write_text("old")
    os.chown(path, 1234, 2345)
    path.chmod(0o640)
    write_text(path, "new")
    about = path.stat()
    assert (about.st_uid, about.st_gid, about.st_mode & 0o777) == (1234, 2345, 0o640)
