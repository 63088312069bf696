"""What tests of the library and of its plug-ins share."""

import json
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import jax
import pytest
from moody import Moody

from stereorecal.cli import main
from stereorecal.io import save_scene
from stereorecal.matching import SAD
from stereorecal.recordings import Scene
from stereorecal.synthetic import default_rig, render

SAD_48 = SAD(num_disparities=48)  # of tests at 320x240: what one file compiles, the others need not


@pytest.fixture(scope="session")
def once(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    """once(name, make): what make() returns, made by the worker that needs it first and kept for all."""
    of_process = tmp_path_factory.getbasetemp()
    folder = of_process.parent if hasattr(request.config, "workerinput") else of_process

    def kept(name: str, make: Callable[[], Any]) -> Any:
        file = folder / f"{name}.pickle"
        if not file.exists():
            whole = file.with_suffix(f".{os.getpid()}")
            whole.write_bytes(pickle.dumps(make()))
            whole.replace(file)
        return pickle.loads(file.read_bytes())

    return kept


@pytest.fixture(scope="session")
def scene(once: Callable[..., Any]) -> Callable[..., Scene]:
    """scene(kind, seed, size, frames): a rendered scene; 160x120 unless a size is given."""

    @cache
    def make(kind: str = "harbour", seed: int = 0, size: tuple[int, int] = (160, 120), frames: int = 1) -> Scene:
        rig = default_rig().resized(size)
        return once(f"{kind}-{seed}-{size[0]}x{size[1]}-{frames}", lambda: render(kind, seed, rig=rig, frames=frames))

    return make


@pytest.fixture
def settings_of_jax() -> Iterator[Callable[..., None]]:
    """settings_of_jax(name=value...): for the time of a test."""
    before: dict[str, Any] = {}

    def set_up(**settings: Any) -> None:
        for name, value in settings.items():
            before.setdefault(name, jax.config.values[name])
            jax.config.update(name, value)

    yield set_up
    set_up(**before)


@pytest.fixture
def install(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """install(group, {name: "module:Class"}, distribution): a distribution (of version 1.2) more, by its metadata in a
    folder of sys.path, as pip leaves it."""

    def one_more(group: str, plugins: dict[str, str], distribution: str = "plug-in") -> None:
        folder = tmp_path_factory.mktemp("site-packages")
        info = folder / f"{distribution.replace('-', '_')}-1.2.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.2\n")
        lines = (f"{name} = {value}\n" for name, value in plugins.items())
        (info / "entry_points.txt").write_text(f"[{group}]\n{''.join(lines)}")
        monkeypatch.syspath_prepend(folder)

    return one_more


@pytest.fixture
def moody(install) -> Callable[..., list[int]]:
    """moody(mood): what the installed strategy "moody" does from now on, told the number of its run; and the seeds of
    its runs. Without a mood it stays where it starts."""
    install("stereorecal.strategies", {"moody": "moody:Moody"})

    def set_up(mood: Callable[[int], None] = lambda run: None) -> list[int]:
        Moody.runs.clear()
        Moody.mood = mood
        return Moody.runs

    set_up()
    return set_up


@dataclass(frozen=True)
class Answer:
    """How a command ended and what it said."""

    code: int
    out: str
    err: str

    def refuses(self, *words: str) -> None:
        """Bad input: exit code 2, nothing on stdout, one sentence on stderr, in which these words are."""
        assert (self.code, self.out, self.err.count("\n")) == (2, "", 1), self
        assert self.err.startswith("stereorecal: "), self
        assert self.err.endswith("\n"), self
        for word in words:
            assert word.lower() in self.err.lower(), (word, self)


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Callable[..., Answer]:
    """command(words...): run a command; an exit by argparse counts as a return."""
    handler = signal.getsignal(signal.SIGTERM)

    def run(*words: object) -> Answer:
        capsys.readouterr()
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = int(end.code or 0)
        finally:
            signal.signal(signal.SIGTERM, handler)
        return Answer(code, *capsys.readouterr())

    return run


_LOADED = """
import contextlib, io, json, sys
from stereorecal.cli import main
for words in sys.argv[1:]:
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        try:
            code = main(words.split())
        except SystemExit as end:
            code = end.code or 0
    loaded = [name for name in ("jax", "cv2", "numpy", "rich", "matplotlib") if name in sys.modules]
    print(json.dumps([code, out.getvalue(), err.getvalue(), loaded]))
"""


@pytest.fixture(scope="session")
def at_once() -> Callable[..., list[tuple[Answer, set[str]]]]:
    """at_once(commands...): how each answers in one process of their own, and the heavy libraries loaded till then."""

    def run(*commands: str) -> list[tuple[Answer, set[str]]]:
        done = subprocess.run([sys.executable, "-c", _LOADED, *commands], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        answers = [json.loads(line) for line in done.stdout.splitlines()]
        return [(Answer(code, out, err), set(loaded)) for code, out, err, loaded in answers]

    return run


@pytest.fixture(scope="session")
def clean_scene(scene: Callable[..., Scene], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene folder with one pair of 160x120; not to be changed."""
    folder = tmp_path_factory.mktemp("scenes") / "clean"
    save_scene(scene(), folder)
    return folder


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real scenes that the environment variable STEREORECAL_DATA names; skips without it."""
    name = os.environ.get("STEREORECAL_DATA")
    if not name:
        pytest.skip("set STEREORECAL_DATA to the folder of real scenes to run this test")
    if not Path(name).is_dir():
        pytest.skip(f"STEREORECAL_DATA={name} is no folder")
    return Path(name)
