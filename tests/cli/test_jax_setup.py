"""The compilation cache lies in the user's cache folder, or nowhere."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

WHERE = """
import contextlib, io, jax
from stereorecal.cli import main
with contextlib.redirect_stdout(io.StringIO()):
    main(["strategies"])
print(jax.config.jax_compilation_cache_dir)
"""


def where(**environment: object) -> str:
    plain = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    given = {name: str(value) for name, value in environment.items()}
    answer = subprocess.run(
        [sys.executable, "-c", WHERE], env=plain | given, capture_output=True, text=True, check=True
    )
    assert answer.stderr == ""
    return answer.stdout.strip()


linux_only = pytest.mark.skipif(
    sys.platform != "linux", reason="the name of the user's cache folder is another one here"
)


@linux_only
def test_in_the_users_cache(tmp_path: Path):
    assert where(XDG_CACHE_HOME=tmp_path) == str(tmp_path / "stereorecal" / "programs")
    assert (tmp_path / "stereorecal" / "programs").is_dir()


@pytest.mark.slow
def test_the_users_own_choice_stands(tmp_path: Path):
    own = tmp_path / "own"
    assert where(XDG_CACHE_HOME=tmp_path, JAX_COMPILATION_CACHE_DIR=own) == str(own)
    assert where(XDG_CACHE_HOME=tmp_path, JAX_ENABLE_COMPILATION_CACHE="false") == "None"
    assert where(XDG_CACHE_HOME=tmp_path, JAX_COMPILATION_CACHE_DIR="gs://bucket/own") == "gs://bucket/own"
    assert list(tmp_path.iterdir()) == [own]


@linux_only
def test_every_command_does_so(tmp_path: Path):
    command = [sys.executable, "-m", "stereorecal", "strategies"]
    plain = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    subprocess.run(command, env=plain | {"XDG_CACHE_HOME": str(tmp_path)}, capture_output=True, check=True)
    assert [folder.name for folder in tmp_path.iterdir()] == ["stereorecal"]


@linux_only
def test_a_user_without_a_home(tmp_path: Path):
    """Whom the machine does not know: as a container runs with a number of nobody's."""
    nobody = "import pwd, sys\npwd.getpwuid = {}.__getitem__\nfrom stereorecal.__main__ import run\nsys.exit(run())"
    plain = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "HOME", "XDG_"))}
    words = [sys.executable, "-c", nobody, "score", tmp_path]
    answer = subprocess.run(words, env=plain, capture_output=True, text=True, check=False)
    first, second = answer.stderr.splitlines()
    assert first.startswith("stereorecal: compiled programs cannot be cached (")
    assert "home directory" in first
    assert "calib.json: there is no such file" in second
    assert answer.returncode == 2


def test_nowhere_to_write_to(tmp_path: Path):
    (tmp_path / "file").write_text("in the way")
    assert where(XDG_CACHE_HOME=tmp_path / "file", HOME=tmp_path / "file") == "None"


@linux_only
@pytest.mark.slow(after=2)
@pytest.mark.parametrize(("command", "told"), [("score {}", True), ("diff {} {}", False), ("matchers check no", True)])
def test_those_who_would_compile_at_every_start_are_told(tmp_path: Path, command: str, told: bool):
    (tmp_path / "file").write_text("in the way")
    words = [sys.executable, "-m", "stereorecal", *command.format(tmp_path, tmp_path).split()]
    plain = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    answer = subprocess.run(
        words, env=plain | {"XDG_CACHE_HOME": str(tmp_path / "file")}, capture_output=True, text=True, check=False
    )
    assert answer.returncode == 2
    lines = answer.stderr.splitlines()
    assert len(lines) == 1 + told
    assert lines[0].startswith("stereorecal: compiled programs cannot be cached") == told


def test_what_compiles_quickly_is_kept_in_a_folder_of_the_users_too(tmp_path: Path):
    seconds = "print(jax.config.jax_persistent_cache_min_compile_time_secs)"
    plain = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    given = {"JAX_COMPILATION_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", WHERE + seconds]
    answer = subprocess.run(command, env=plain | given, capture_output=True, text=True, check=True)
    assert answer.stdout.split() == [str(tmp_path), "0.1"]


@pytest.mark.parametrize("platform", ["cuda", "cda"])
def test_a_platform_that_is_not_there(tmp_path: Path, platform: str):
    command = [sys.executable, "-m", "stereorecal", "score", tmp_path]
    given = {"JAX_PLATFORMS": platform, "XDG_CACHE_HOME": str(tmp_path)}
    answer = subprocess.run(command, env=os.environ | given, capture_output=True, text=True, check=False)
    if "there is no such file" in answer.stderr:
        pytest.skip(f"JAX computes on {platform} here")
    assert answer.returncode == 2
    assert f"stereorecal: JAX_PLATFORMS is '{platform}', which JAX cannot use here" in answer.stderr


@pytest.mark.slow  # as where there is no home
def test_a_folder_of_the_users_that_cannot_be_made(tmp_path: Path):
    (tmp_path / "file").write_text("in the way")
    command = [sys.executable, "-m", "stereorecal", "score", tmp_path]
    given = {"JAX_COMPILATION_CACHE_DIR": str(tmp_path / "file" / "own")}
    answer = subprocess.run(command, env=os.environ | given, capture_output=True, text=True, check=False)
    assert answer.returncode == 2
    first, second = answer.stderr.splitlines()
    assert first.startswith("stereorecal: compiled programs cannot be cached")
    assert "no such file" in second
