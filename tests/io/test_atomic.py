"""Writing files whole or not at all."""

import os
from pathlib import Path

import pytest

from stereorecal._errors import InputError
from stereorecal.io._atomic import make_folder, write_bytes, write_text


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
