"""Programs that are kept: read back in the next process, made anew in doubt, and never a reason to fail."""

import threading
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from stereorecal import _kept
from stereorecal._kept import kept
from stereorecal.matching import SAD

TRACES: list[str] = []


def program(a, b, *, matcher=None, times: int = 1):
    TRACES.append("traced")
    return times * (a["x"] + b), a["x"] * 2


@pytest.fixture
def folder(tmp_path, monkeypatch):
    TRACES.clear()
    monkeypatch.setattr(_kept, "_folder", lambda: tmp_path / "kept")
    return tmp_path / "kept"


def asked(fresh=None, value: float = 1.0, **static):
    call = fresh or kept(program, static=("matcher", "times"))
    return [np.asarray(leaf) for leaf in call({"x": jnp.full(3, value)}, np.float32(2.0), **static)]


def test_traced_once_for_all_processes(folder):
    first = asked(times=3)
    np.testing.assert_array_equal(first[0], [9, 9, 9])
    np.testing.assert_array_equal(first[1], [2, 2, 2])
    assert len(TRACES) == 1
    np.testing.assert_array_equal(asked(times=3, value=5.0)[0], [21, 21, 21])  # as another process would
    assert len(TRACES) == 1
    assert len(list(folder.iterdir())) == 1


def test_everything_that_makes_another_program_does(folder):
    call = kept(program, static=("matcher", "times"))
    for static in ({}, {"times": 2}, {"matcher": SAD(num_disparities=16)}, {"matcher": SAD(num_disparities=32)}):
        asked(call, **static)
        asked(call, **static)
    call({"x": jnp.zeros(4)}, np.float32(1))
    call({"x": jnp.zeros(4)}, np.int32(1))
    assert len(TRACES) == len(list(folder.iterdir())) == 6


@pytest.mark.parametrize("change", ["cut short", "empty", "nonsense", "a folder"])
def test_what_cannot_be_read_is_made_anew(folder, change):
    asked()
    (path,) = folder.iterdir()
    content = path.read_bytes()
    path.unlink()
    if change == "a folder":
        path.mkdir()
    else:
        path.write_bytes({"cut short": content[: len(content) // 2], "empty": b"", "nonsense": b"x" * 999}[change])
    np.testing.assert_array_equal(asked()[0], [3, 3, 3])
    assert len(TRACES) == 2


def test_other_versions_and_other_files_are_other_programs(folder, monkeypatch):
    asked()
    monkeypatch.setattr(_kept, "_made_with", lambda: ("another",))
    asked()
    assert len(TRACES) == len(list(folder.iterdir())) == 2


def test_a_place_that_takes_nothing_is_no_reason_to_fail(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setattr(_kept, "_folder", lambda: tmp_path / "file" / "kept")
    np.testing.assert_array_equal(asked()[0], [3, 3, 3])


class Foreign(SAD):
    """A matcher of somebody else's, whose code may change."""


def test_what_rests_on_other_code_is_not_kept(folder):
    asked(matcher=Foreign(num_disparities=16))
    assert not folder.exists()


def test_off_where_jax_keeps_nothing(monkeypatch, tmp_path):
    for name, value in (("jax_compilation_cache_dir", None), ("jax_enable_compilation_cache", False)):
        settings = dict(jax.config.values) | {"jax_compilation_cache_dir": str(tmp_path), name: value}
        monkeypatch.setattr(type(jax.config), "values", settings)
        assert _kept._folder() is None
        monkeypatch.undo()


def test_compiled_ahead_is_compiled_once(folder):
    call = kept(program, static=("matcher", "times"))
    arguments = ({"x": jnp.full(3, 1.0)}, np.float32(2.0))
    for _ in range(3):
        call.ahead(*arguments, times=3)
    np.testing.assert_array_equal(call(*arguments, times=3)[0], [9, 9, 9])
    call.ahead(*arguments, times=3)
    assert len(TRACES) == 1
    assert not call._begun


def test_a_call_waits_for_what_is_begun(folder):
    begun, go_on = threading.Event(), threading.Event()

    def slow(x):
        TRACES.append("traced")
        if x.shape == (2,):
            begun.set()
            assert go_on.wait(30)
        return (2 * x,)

    call = kept(slow)
    call.ahead(np.ones(2))
    assert begun.wait(30)
    with ThreadPoolExecutor(1) as other:
        waiting = other.submit(call, np.ones(2))
        with pytest.raises(TimeoutError):
            waiting.result(timeout=0.2)
        go_on.set()
        np.testing.assert_array_equal(waiting.result(timeout=30)[0], [2, 2])
    assert len(TRACES) == 1


def test_what_fails_ahead_fails_when_it_is_called(folder):
    def broken(x):
        raise ValueError("no such program")

    call = kept(broken)
    call.ahead(np.ones(3))
    with pytest.raises(ValueError, match="no such program"):
        call(np.ones(3))
