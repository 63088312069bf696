"""The cache of programs: read in the next process, made anew in doubt, and never a reason to fail."""

import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from parts_of_repairs import _compile_cache

from stereorecal.matching import SAD

try:
    from jax import enable_x64
except ImportError:  # before JAX 0.8
    from jax.experimental import enable_x64

TRACES: list[str] = []


def program(a, b, *, matcher=None, times: int = 1):
    TRACES.append("traced")
    return times * (a["x"] + b), a["x"] * 2


@pytest.fixture
def folder(tmp_path, settings_of_jax):
    """Where programs are kept that were traced; what JAX itself keeps stays where it was."""
    jax.jit(lambda x: x + 1.0)(1.0)  # its cache is opened once
    TRACES.clear()
    settings_of_jax(jax_compilation_cache_dir=str(tmp_path / "cache"))
    return tmp_path / "cache" / "stereorecal"


def result(fresh=None, value: float = 1.0, **static):
    call = fresh or _compile_cache.CachedProgram(program, static=("matcher", "times"))
    return [np.asarray(leaf) for leaf in call({"x": jnp.full(3, value)}, np.float32(2.0), **static)]


def test_traced_once_for_all_processes(folder):
    first = result(times=3)
    np.testing.assert_array_equal(first[0], [9, 9, 9])
    np.testing.assert_array_equal(first[1], [2, 2, 2])
    assert len(TRACES) == 1
    np.testing.assert_array_equal(result(times=3, value=5.0)[0], [21, 21, 21])  # as another process would
    assert len(TRACES) == 1
    assert len(list(folder.iterdir())) == 1


def test_made_anew_beside_what_jax_keeps_it_is_whole(folder, settings_of_jax):
    """A program that JAX read from its own cache would be written without its code."""
    settings_of_jax(jax_persistent_cache_min_compile_time_secs=0.0)
    for _ in range(3):
        np.testing.assert_array_equal(result(times=4)[0], [12, 12, 12])
        for path in folder.iterdir():
            path.unlink()
    result(times=4)
    np.testing.assert_array_equal(result(times=4, value=2.0)[0], [16, 16, 16])
    assert len(TRACES) == 4


def test_everything_that_makes_another_program_does(folder):
    call = _compile_cache.CachedProgram(program, static=("matcher", "times"))
    for static in ({}, {"times": 2}, {"matcher": SAD(num_disparities=16)}, {"matcher": SAD(num_disparities=32)}):
        result(call, **static)
        result(call, **static)
    call({"x": jnp.zeros(4)}, np.float32(1))
    call({"x": jnp.zeros(4)}, np.int32(1))
    assert len(TRACES) == len(list(folder.iterdir())) == 6


def test_custom_calls_make_another_program(folder, monkeypatch):
    """What calls a kernel is for processes that have it, the same options without it for the others."""
    for calls in ((), ("kernel",), (), ("kernel",)):
        monkeypatch.setattr(SAD, "custom_calls", calls)
        result(matcher=SAD(num_disparities=16))
    assert len(TRACES) == len(list(folder.iterdir())) == 2


@pytest.mark.parametrize("change", ["cut short", "empty", "nonsense", "a folder"])
def test_what_cannot_be_read_is_made_anew(folder, change):
    result()
    (path,) = folder.iterdir()
    content = path.read_bytes()
    path.unlink()
    if change == "a folder":
        path.mkdir()
    else:
        path.write_bytes({"cut short": content[: len(content) // 2], "empty": b"", "nonsense": b"x" * 999}[change])
    np.testing.assert_array_equal(result()[0], [3, 3, 3])
    assert len(TRACES) == 2


def test_what_is_read_and_cannot_run_is_made_anew(folder):
    """As a program for arguments of another shape."""
    call = _compile_cache.CachedProgram(program, static=("matcher", "times"))
    call({"x": jnp.zeros(4)}, np.float32(1))
    (other,) = folder.iterdir()
    content = other.read_bytes()
    other.unlink()
    result()
    (path,) = folder.iterdir()
    path.write_bytes(content)
    fresh = _compile_cache.CachedProgram(program, static=("matcher", "times"))
    for value, expected in ((1.0, 3.0), (2.0, 4.0)):
        np.testing.assert_array_equal(result(fresh, value)[0], [expected] * 3)
    assert not path.exists()  # the next process makes it
    np.testing.assert_array_equal(result()[0], [3, 3, 3])
    assert path.exists()


def test_other_versions_and_other_files_are_other_programs(folder, monkeypatch):
    result()
    monkeypatch.setattr(_compile_cache, "_made_by", lambda: ("another",))
    result()
    assert len(TRACES) == len(list(folder.iterdir())) == 2


def test_a_place_that_takes_nothing_is_no_reason_to_fail(folder, settings_of_jax, tmp_path):
    (tmp_path / "file").write_text("no folder")
    settings_of_jax(jax_compilation_cache_dir=str(tmp_path / "file" / "cache"))
    np.testing.assert_array_equal(result()[0], [3, 3, 3])


class Foreign(SAD):
    """A matcher of somebody else's, whose code may change."""


def test_a_program_with_code_of_others_is_not_cached(folder):
    result(matcher=Foreign(num_disparities=16))
    assert not folder.exists()


@pytest.mark.parametrize(
    "off",
    [
        {"jax_compilation_cache_dir": None},
        {"jax_enable_compilation_cache": False},
        {"jax_compilation_cache_dir": "gs://bucket"},
        {"jax_disable_jit": True},
    ],
    ids=lambda off: "{0[0]}={0[1]}".format(*off.items()),
)
def test_off_where_jax_keeps_nothing_here(folder, settings_of_jax, off, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    settings_of_jax(**off)
    np.testing.assert_array_equal(result()[0], [3, 3, 3])
    assert not list(tmp_path.iterdir())


def test_compiled_in_the_background_is_compiled_once(folder):
    call = _compile_cache.CachedProgram(program, static=("matcher", "times"))
    arguments = ({"x": jnp.full(3, 1.0)}, np.float32(2.0))
    for _ in range(3):
        call.compile_in_background(*arguments, times=3)
    np.testing.assert_array_equal(call(*arguments, times=3)[0], [9, 9, 9])
    call.compile_in_background(*arguments, times=3)
    called = _compile_cache.CachedProgram(program, static=("matcher", "times"))
    called(*arguments, times=2)
    called.compile_in_background(*arguments, times=2)  # which it is already
    assert len(TRACES) == 2
    assert not called._compiling


def test_a_call_waits_for_what_is_begun(folder):
    begun, go_on = threading.Event(), threading.Event()

    def slow(x):
        TRACES.append("traced")
        if x.shape == (2,):
            begun.set()
            assert go_on.wait(30)
        return (2 * x,)

    call = _compile_cache.CachedProgram(slow)
    call.compile_in_background(np.ones(2))
    assert begun.wait(30)
    with ThreadPoolExecutor(1) as other:
        waiting = other.submit(call, np.ones(2))
        with pytest.raises(TimeoutError):
            waiting.result(timeout=0.2)
        go_on.set()
        np.testing.assert_array_equal(waiting.result(timeout=30)[0], [2, 2])
    assert len(TRACES) == 1


def test_what_fails_in_the_background_fails_when_it_is_called(folder):
    def broken(x):
        raise ValueError("no such program")

    call, after = _compile_cache.CachedProgram(broken), _compile_cache.CachedProgram(program, static=("times",))
    call.compile_in_background(np.ones(3))
    after.compile_in_background({"x": jnp.zeros(3)}, np.float32(0))
    with pytest.raises(ValueError, match="no such program"):
        call(np.ones(3))
    after({"x": jnp.zeros(3)}, np.float32(0))
    assert TRACES == ["traced"]  # by the thread, which has survived


def test_compiled_in_the_background_without_a_cache(folder, settings_of_jax):
    settings_of_jax(jax_enable_compilation_cache=False)
    call = _compile_cache.CachedProgram(program, static=("times",))
    call.compile_in_background({"x": jnp.full(3, 1.0)}, np.float32(2.0), times=3)
    np.testing.assert_array_equal(call({"x": jnp.full(3, 1.0)}, np.float32(2.0), times=3)[0], [9, 9, 9])
    assert len(TRACES) == 1


def test_settings_of_one_thread_make_another_program(folder):
    """Contexts of JAX are those of a thread: the background thread has its own."""
    call = _compile_cache.CachedProgram(program, static=("times",))
    with enable_x64(True):
        call.compile_in_background({"x": np.ones(3)}, np.ones(3))
        found = call({"x": np.ones(3)}, np.ones(3))
    assert found[0].dtype == np.float64
    assert call({"x": np.ones(3)}, np.ones(3))[0].dtype == np.float32
    assert len(TRACES) == 2


def test_what_runs_in_the_background():
    """A process that ends waits for nothing that has not begun."""
    code = """
import threading, time
from stereorecal._compile_cache import _BACKGROUND
began = threading.Event()
_BACKGROUND.submit(lambda: (began.set(), time.sleep(0.5), print("last", flush=True)))
_BACKGROUND.submit(lambda: print("never", flush=True))
began.wait()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("last\n", "")


def test_what_is_kept_is_kept_once(tmp_path):
    """Not by JAX, too, which would write each program that takes long enough to compile."""
    code = """
import sys, jax, numpy as np
from stereorecal._compile_cache import CachedProgram
jax.config.update("jax_compilation_cache_dir", sys.argv[1])
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.jit(lambda x: x + 1)(np.ones(3))
def doubled(x):
    return (2 * x,)
print(CachedProgram(doubled)(np.ones(2))[0])
"""
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", code, tmp_path], capture_output=True, text=True, check=True)
        assert done.stdout == "[2. 2.]\n"
        names = [path.name for path in tmp_path.rglob("*") if path.is_file()]
        assert sum(name.startswith("doubled") for name in names) == sum("doubled" in name for name in names) == 1
        assert len(names) > 1  # what is JAX's own stays
