"""Programs that outlive a process: what JAX traces for a second at every start is exported and read back instead.

JAX's own compilation cache keeps what XLA compiled, and needs the traced program to find it. Kept programs lie in a
folder of that cache, and are used where it is switched on. Each is keyed by everything that it was traced from: this
package's files, versions, platform, structure, shapes and static arguments; where in doubt it is traced anew.
What will be needed soon can be compiled ahead, in a thread.
"""

import hashlib
import logging
import os
import threading
import uuid
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import cache, update_wrapper
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
import jax.export
import numpy as np

from stereorecal._ahead import begin
from stereorecal._arrays import AnyArray
from stereorecal._version import __version__

LOG = logging.getLogger("stereorecal")
_FOLDER = "stereorecal-traced"
_TELLING = ("jax_enable_x64", "jax_numpy_dtype_promotion", "jax_default_matmul_precision")
Leaves = tuple[AnyArray, ...]


class Kept:
    """A function that is compiled, and kept across processes where JAX's compilation cache is switched on."""

    def __init__(self, function: Callable[..., Leaves], static: tuple[str, ...]):
        update_wrapper(self, function)
        self._function = function
        self.compiled = jax.jit(function, static_argnames=static)  # where nothing is kept
        self._programs: dict[Any, Callable[..., Any]] = {}
        self._tracing = threading.Lock()
        self._begun: dict[Any, Future[None]] = {}

    def __call__(self, *arguments: Any, **statics: Any) -> Leaves:
        folder = _folder_of(statics)
        if folder is None and not self._begun:
            return self.compiled(*arguments, **statics)
        key = _key(arguments, statics)
        if begun := self._begun.get(key):
            begun.result()
        return self._run(key, folder, arguments, statics)

    def ahead(self, *arguments: Any, **statics: Any) -> None:
        """Begin to compile in a thread what such arguments need; a call waits until that is done."""
        key = _key(arguments, statics)

        def work() -> None:
            if _key(arguments, statics) == key:  # else JAX is set up otherwise in the caller's thread alone
                self._run(key, _folder_of(statics), arguments, statics)

        if key not in self._programs and key not in self._begun:
            self._begun[key] = begin(work)

    def _run(self, key: Any, folder: Path | None, arguments: tuple[Any, ...], statics: dict[str, Any]) -> Leaves:
        if folder is None:
            return self.compiled(*arguments, **statics)
        program = self._programs.get(key)
        if program is None:
            with self._tracing:
                program = self._programs.get(key) or _program(self._function, arguments, statics, folder)
                self._programs[key] = program
        return tuple(program(*jax.tree.leaves(arguments)))


def kept(function: Callable[..., Leaves], *, static: tuple[str, ...] = ()) -> Kept:
    """`function`, compiled, and kept.

    Args:
        function: pure; pytrees in, a tuple of arrays out.
        static: names of its keyword arguments that are part of the program: hashable, with a `repr` that tells all.
            One that is, or belongs to, somebody else's code is not kept, since that code may change.
    """
    return Kept(function, static)


def _key(arguments: tuple[Any, ...], statics: dict[str, Any]) -> Any:
    leaves, structure = jax.tree.flatten(arguments)
    shapes = tuple((np.shape(x), jax.dtypes.result_type(x)) for x in leaves)
    return (os.getpid(), _settings(), structure, shapes, *statics.items())


def _program(function: Callable, arguments: tuple[Any, ...], statics: dict[str, Any], folder: Path) -> Callable:
    leaves, structure = jax.tree.flatten(arguments)
    shapes = [jax.ShapeDtypeStruct(np.shape(x), jax.dtypes.result_type(x)) for x in leaves]
    known = [function.__module__, function.__qualname__, str(structure), str(shapes), _told(statics)]
    known += [_settings(), _made_with()]
    path = folder / f"{function.__name__.strip('_')}-{hashlib.sha256(repr(known).encode()).hexdigest()[:32]}"
    with suppress(Exception):  # missing, cut short, of another format: whatever it is, it is traced anew
        return jax.jit(jax.export.deserialize(bytearray(path.read_bytes())).call)

    LOG.info("compiling %s; it is kept in %s", function.__name__.strip("_"), folder)

    def flat(*leaves: jax.Array) -> Leaves:
        return function(*jax.tree.unflatten(structure, leaves), **statics)

    flat.__name__ = function.__name__
    exported = jax.export.export(jax.jit(flat))(*shapes)
    with suppress(OSError):  # a full disk, a folder that went away: then not
        _write(path, bytes(exported.serialize()))
    return jax.jit(exported.call)


def _told(statics: dict[str, Any]) -> list[tuple[str, str]]:
    return [
        (name, f"{value.__module__}.{value.__qualname__}" if callable(value) else repr(value))
        for name, value in statics.items()
    ]


def _ours(value: Any) -> bool:
    """Whether a static argument is plain, or of this package."""
    module = value.__module__ if callable(value) else type(value).__module__
    return module == "builtins" or module.partition(".")[0] == "stereorecal"


def _folder_of(statics: dict[str, Any]) -> Path | None:
    """Where a program is kept; None where it is not."""
    return _folder() if all(_ours(value) for value in statics.values()) else None


def _folder() -> Path | None:
    """Where programs are kept; None where they are not."""
    settings = jax.config.values
    folder = settings["jax_compilation_cache_dir"]
    return Path(folder) / _FOLDER if folder and settings["jax_enable_compilation_cache"] else None


def _settings() -> tuple[Any, ...]:
    """What JAX was told that makes another program, perhaps in this thread alone."""
    return tuple(getattr(jax.config, name) for name in _TELLING)


@cache
def _made_with() -> tuple[Any, ...]:
    """What a program was traced by: versions, the platform, and this package's files as they are."""
    root = Path(__file__).parent
    files = [(str(p.relative_to(root)), p.stat().st_size, p.stat().st_mtime_ns) for p in sorted(root.rglob("*.py"))]
    names = ("jax", "jaxlib", "numpy")
    return (__version__, *(version(name) for name in names), jax.default_backend(), files)


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
