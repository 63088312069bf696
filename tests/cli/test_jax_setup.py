"""The compilation cache lies in the user's cache folder, or nowhere."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import jax
import pytest
from parts_of_repairs import use_compile_cache

WHERE = """
import contextlib, io, jax
from stereorecal.cli import main
with contextlib.redirect_stdout(io.StringIO()):
    main(["strategies"])
print(jax.config.jax_compilation_cache_dir)
"""


def run(
    *words: object, without: tuple[str, ...] = ("JAX_",), **environment: object
) -> subprocess.CompletedProcess[str]:
    """Python with these words, and nothing in its environment that begins so but what is given."""
    plain = {k: v for k, v in os.environ.items() if not k.startswith(without)}
    given = {name: str(value) for name, value in environment.items()}
    return subprocess.run([sys.executable, *words], env=plain | given, capture_output=True, text=True, check=False)


def where(**environment: object) -> str:
    answer = run("-c", WHERE, **environment)
    assert (answer.returncode, answer.stderr) == (0, "")
    return answer.stdout.strip()


linux_only = pytest.mark.skipif(
    sys.platform != "linux", reason="the name of the user's cache folder is another one here"
)


@linux_only
def test_in_the_users_cache(tmp_path: Path):
    assert where(XDG_CACHE_HOME=tmp_path) == str(tmp_path / "stereorecal" / "programs")
    assert (tmp_path / "stereorecal" / "programs").is_dir()


@pytest.mark.parametrize(
    ("setting", "value", "made"),
    [
        ("jax_compilation_cache_dir", "own", ["own"]),
        ("jax_compilation_cache_dir", "gs://bucket/own", []),
        ("jax_enable_compilation_cache", False, []),
    ],
)
def test_the_users_own_choice_stands(tmp_path: Path, monkeypatch, settings_of_jax, setting, value, made: list[str]):
    """And what compiles quickly is kept there, too."""
    seconds = "jax_persistent_cache_min_compile_time_secs"
    settings_of_jax(**{seconds: 1.0, setting: value})
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv(seconds.upper(), raising=False)
    with warnings.catch_warnings():
        assert use_compile_cache() is None
    assert jax.config.values[setting] == value
    assert jax.config.values[seconds] == (0.1 if made else 1.0)
    assert [path.name for path in tmp_path.iterdir()] == made


@linux_only
def test_a_user_without_a_home(tmp_path: Path):
    """Whom the machine does not know: as a container runs with a number of nobody's."""
    nobody = "import pwd, sys\npwd.getpwuid = {}.__getitem__\nfrom stereorecal.__main__ import run\nsys.exit(run())"
    answer = run("-c", nobody, "score", tmp_path, without=("JAX_", "HOME", "XDG_"))
    first, second = answer.stderr.splitlines()
    assert first.startswith("stereorecal: compiled programs cannot be cached (")
    assert "home directory" in first
    assert "calib.json: there is no such file" in second
    assert answer.returncode == 2


@linux_only
@pytest.mark.slow(after=2)
@pytest.mark.parametrize(
    ("command", "place", "told"),
    [
        ("score {}", "XDG_CACHE_HOME", True),
        ("diff {} {}", "XDG_CACHE_HOME", False),
        ("score {}", "JAX_COMPILATION_CACHE_DIR", True),
    ],
)
def test_those_who_would_compile_at_every_start_are_told(tmp_path: Path, command: str, place: str, told: bool):
    (tmp_path / "file").write_text("in the way")
    words = command.format(tmp_path, tmp_path).split()
    answer = run("-m", "stereorecal", *words, **{place: tmp_path / "file" / "own"})
    assert answer.returncode == 2
    lines = answer.stderr.splitlines()
    assert len(lines) == 1 + told
    assert lines[0].startswith("stereorecal: compiled programs cannot be cached") == told


@pytest.mark.parametrize("platform", ["cuda", "cda"])
def test_a_platform_that_is_not_there(tmp_path: Path, platform: str):
    answer = run("-m", "stereorecal", "score", tmp_path, JAX_PLATFORMS=platform, XDG_CACHE_HOME=tmp_path)
    if "there is no such file" in answer.stderr:
        pytest.skip(f"JAX computes on {platform} here")
    assert answer.returncode == 2
    assert f"stereorecal: JAX_PLATFORMS is '{platform}', which JAX cannot use here" in answer.stderr


SHARES = """
import os, jax
from stereorecal.cli import _jax_setup
jax.devices = lambda: print(os.environ["XLA_PYTHON_CLIENT_PREALLOCATE"])  # the memory is taken then
_jax_setup.set_up_platform()
"""


@pytest.mark.parametrize(("own", "then"), [({}, "false"), ({"XLA_PYTHON_CLIENT_PREALLOCATE": "true"}, "true")])
def test_a_gpu_is_shared(own: dict[str, str], then: str):
    """JAX would take most of its memory for the first process of several."""
    answer = run("-c", SHARES, without=("JAX_", "XLA_"), JAX_PLATFORMS="cpu", **own)
    assert answer.stdout == f"{then}\n"
