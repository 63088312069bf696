"""Compiled programs are kept where the user keeps such things, or nowhere."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

WHERE = """
import jax
from stereorecal.cli._compiled import keep_compiled_programs
keep_compiled_programs()
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


@pytest.mark.skipif(sys.platform != "linux", reason="the name of the user's cache folder is another one here")
def test_in_the_users_cache(tmp_path: Path):
    assert where(XDG_CACHE_HOME=tmp_path) == str(tmp_path / "stereorecal" / "programs")
    assert (tmp_path / "stereorecal" / "programs").is_dir()


def test_the_users_own_choice_stands(tmp_path: Path):
    own = tmp_path / "own"
    assert where(XDG_CACHE_HOME=tmp_path, JAX_COMPILATION_CACHE_DIR=own) == str(own)
    assert where(XDG_CACHE_HOME=tmp_path, JAX_ENABLE_COMPILATION_CACHE="false") == "None"
    assert list(tmp_path.iterdir()) == []


def test_nowhere_to_write_to(tmp_path: Path):
    (tmp_path / "file").write_text("in the way")
    assert where(XDG_CACHE_HOME=tmp_path / "file", HOME=tmp_path / "file") == "None"
