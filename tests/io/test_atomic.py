"""Writing files whole or not at all."""

import os
from contextlib import nullcontext
from pathlib import Path

import pytest
from machine import at_call, raising

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


def test_the_new_file_is_complete_before_it_gets_its_name(tmp_path: Path):
    path, seen = tmp_path / "a.json", []

    def check(source, target):
        assert Path(source).read_text() == "new"
        assert Path(source).parent == tmp_path
        assert not path.exists()
        seen.append(target)

    with at_call("replace", check):
        write_text(path, "new")
    assert path.read_text() == "new"
    assert len(seen) == 1


def test_permissions_are_those_of_any_new_file(tmp_path: Path):
    write_text(tmp_path / "a", "x")
    (tmp_path / "b").write_text("x")
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode


def test_a_link_stays_a_link(tmp_path: Path):
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to("target")
    write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "new"


def test_devices_are_written_to_not_replaced(tmp_path: Path):
    null = Path(os.devnull)
    write_text(null, "x")
    assert not null.is_file()


def test_bad_places(tmp_path: Path):
    (tmp_path / "file").write_text("x")
    for place in (tmp_path / "missing" / "a.json", tmp_path / "file" / "a.json", tmp_path):
        with pytest.raises(InputError, match="cannot be written") as error:
            write_text(place, "x")
        assert str(place) in str(error.value)
    with pytest.raises(InputError, match="cannot become a folder"):
        make_folder(tmp_path / "file" / "sub")


@pytest.mark.parametrize("links", [True, False])
def test_a_file_that_somebody_else_makes_meanwhile(tmp_path: Path, links: bool):
    """It stays, also where the file system has no links; without it the file is written."""
    path = tmp_path / "a.json"
    none = raising(PermissionError(1, "Operation not permitted"))
    with nullcontext() if links else at_call("link", none):
        write_text(tmp_path / "b.json", "mine", replace=False)
        assert (tmp_path / "b.json").read_text() == "mine"
        with (
            at_call("fsync", lambda _: path.write_text("theirs")),
            pytest.raises(InputError, match=r"a\.json: the file exists already"),
        ):
            write_text(path, "mine", replace=False)
    assert path.read_text() == "theirs"
    assert sorted(os.listdir(tmp_path)) == ["a.json", "b.json"]


def test_the_longest_names(tmp_path: Path):
    for name in ("a" * 255, "ä" * 127):
        write_text(tmp_path / name, "x")
    assert len(os.listdir(tmp_path)) == 2


def test_names_that_are_no_text(tmp_path: Path):
    """As a page shows a folder whose name is not UTF-8."""
    write_text(tmp_path / "a", os.fsdecode(b"bad\xff"))
    assert (tmp_path / "a").read_text() == "bad\\udcff"


def test_a_signal_between_two_files_that_belong_together(tmp_path: Path):
    left, right = tmp_path / "left", tmp_path / "right"
    left.write_text("old")

    def interrupted(source, target):
        if Path(target) == right:
            raise KeyboardInterrupt

    with at_call("replace", interrupted), pytest.raises(KeyboardInterrupt):
        write_files({left: b"new", right: b"new"})
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
