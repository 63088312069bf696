"""Writing files whole or not at all."""

import os
from pathlib import Path

import pytest

from stereorecal import InputError
from stereorecal.io import make_folder, write_bytes, write_files, write_text
from stereorecal.io._atomic import FileTaken


def test_writes_and_replaces(tmp_path: Path):
    path = tmp_path / "a.json"
    write_text(path, "größer")
    assert path.read_bytes() == "größer".encode()
    write_bytes(str(path), b"new")
    assert path.read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["a.json"]


@pytest.mark.parametrize("function", ["fsync", "replace"])
@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, OSError(28, "No space left on device")])
def test_an_interrupted_write_leaves_the_old_file(tmp_path: Path, monkeypatch, function: str, error):
    path = tmp_path / "a.json"
    path.write_text("old")

    def fail(*_):
        raise error

    monkeypatch.setattr(os, function, fail)
    with pytest.raises(InputError if isinstance(error, OSError) else error):
        write_text(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.json"]


def test_the_new_file_is_complete_before_it_gets_its_name(tmp_path: Path, monkeypatch):
    path, replace = tmp_path / "a.json", os.replace

    def check(source, target):
        assert Path(source).read_text() == "new"
        assert Path(source).parent == tmp_path
        assert not path.exists()
        replace(source, target)

    monkeypatch.setattr(os, "replace", check)
    write_text(path, "new")
    assert path.read_text() == "new"


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
def test_a_file_that_somebody_else_makes_meanwhile(tmp_path: Path, monkeypatch, links: bool):
    """It stays, also where the file system has no links; without it the file is written."""
    path, fsync = tmp_path / "a.json", os.fsync

    def meanwhile(file: int) -> None:
        fsync(file)
        path.write_text("theirs")

    def none(*_):
        raise PermissionError(1, "Operation not permitted")

    if not links:
        monkeypatch.setattr(os, "link", none)
    write_text(tmp_path / "b.json", "mine", replace=False)
    assert (tmp_path / "b.json").read_text() == "mine"
    monkeypatch.setattr(os, "fsync", meanwhile)
    with pytest.raises(FileTaken, match=r"a\.json: the file exists already"):
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


def test_a_signal_between_two_files_that_belong_together(tmp_path: Path, monkeypatch):
    left, right, replace = tmp_path / "left", tmp_path / "right", os.replace
    left.write_text("old")

    def interrupted(source, target):
        if Path(target) == right:
            raise KeyboardInterrupt
        replace(source, target)

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
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
