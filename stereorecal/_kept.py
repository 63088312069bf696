"""Programs that outlive a process: what JAX traces for a second at every start is exported and read back instead.

JAX's own compilation cache keeps what XLA compiled, and needs the traced program to find it. Kept programs lie in a
folder of that cache, and are used where it is switched on. Each is keyed by everything that it was traced from: this
package's files, versions, platform, structure, shapes and static arguments; where in doubt it is traced anew.
"""

import hashlib
import logging
import os
import threading
import uuid
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
import jax.export
import numpy as np

from stereorecal._arrays import AnyArray
from stereorecal._version import __version__

LOG = logging.getLogger("stereorecal")
_FOLDER = "stereorecal-traced"
Leaves = tuple[AnyArray, ...]


def kept(function: Callable[..., Leaves], *, static: tuple[str, ...] = ()) -> Callable[..., Leaves]:
    """`function`, compiled, and kept across processes where JAX's compilation cache is switched on.

    Args:
        function: pure; pytrees in, a tuple of arrays out.
        static: names of its keyword arguments that are part of the program: hashable, with a `repr` that tells all.
            One that is, or belongs to, somebody else's code is not kept, since that code may change.
    """
    compiled = jax.jit(function, static_argnames=static)
    programs: dict[Any, Callable[..., Any]] = {}
    lock = threading.Lock()

    @wraps(function)
    def call(*arguments: Any, **statics: Any) -> Leaves:
        folder = _folder()
        if folder is None or not all(_ours(value) for value in statics.values()):
            return compiled(*arguments, **statics)
        leaves, structure = jax.tree.flatten(arguments)
        key = (structure, tuple((np.shape(x), jax.dtypes.result_type(x)) for x in leaves), *statics.items())
        program = programs.get(key)
        if program is None:
            with lock:
                program = programs.get(key) or _program(function, structure, leaves, statics, folder)
                programs[key] = program
        return tuple(program(*leaves))

    call.compiled = compiled  # pyright: ignore[reportAttributeAccessIssue]  for those who look at JAX's caches
    return call


def _program(function: Callable, structure: Any, leaves: list, statics: dict[str, Any], folder: Path) -> Callable:
    shapes = [jax.ShapeDtypeStruct(np.shape(x), jax.dtypes.result_type(x)) for x in leaves]
    known = [function.__module__, function.__qualname__, str(structure), str(shapes), _told(statics), _made_with()]
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


def _folder() -> Path | None:
    """Where programs are kept; None where they are not."""
    settings = jax.config.values
    folder = settings["jax_compilation_cache_dir"]
    return Path(folder) / _FOLDER if folder and settings["jax_enable_compilation_cache"] else None


@cache
def _made_with() -> tuple[Any, ...]:
    """What a program was traced by: versions, this package's files as they are, and what JAX was told."""
    root = Path(__file__).parent
    files = [(str(p.relative_to(root)), p.stat().st_size, p.stat().st_mtime_ns) for p in sorted(root.rglob("*.py"))]
    names = ("jax", "jaxlib", "numpy")
    settings = (
        jax.default_backend(),
        jax.config.values["jax_enable_x64"],
        jax.config.values["jax_numpy_dtype_promotion"],
    )
    return (__version__, *(version(name) for name in names), *settings, files)


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
