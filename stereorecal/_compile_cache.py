"""The cache of compiled programs: what takes seconds to trace and to compile is read from a file in each other process.

JAX's own compilation cache holds what XLA compiled, but needs the traced program to find it, which takes a second. This
cache is a folder inside JAX's and is used where JAX's is switched on. The key of a program is everything that it was
made from: the files of this package, versions, the processor, structure, shapes and static arguments. In doubt a
program is made anew. A program that is needed soon can be made in the background.
"""

import hashlib
import logging
import os
import pickle
import platform
import threading
import uuid
import zlib
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import cache, update_wrapper
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jax.experimental import serialize_executable

from stereorecal._arrays import AnyArray
from stereorecal._version import __version__

LOG = logging.getLogger("stereorecal")
_FOLDER = "stereorecal"
_SETTINGS = ("jax_enable_x64", "jax_numpy_dtype_promotion", "jax_default_matmul_precision", "jax_optimization_level")
_VARIABLES = ("XLA_FLAGS", "LIBTPU_INIT_ARGS", "NPROC", "PJRT_NPROC")
Leaves = tuple[AnyArray, ...]

_BACKGROUND = ThreadPoolExecutor(1, "compile")
# A process that ends waits for nothing that has not begun; what `atexit` calls would come after the waiting.
threading._register_atexit(_BACKGROUND.shutdown, wait=False, cancel_futures=True)  # pyright: ignore


class CachedProgram:
    """A compiled function, cached across processes where JAX's compilation cache is switched on.

    Args:
        function: pure; pytrees in, a tuple of arrays out.
        static: names of its keyword arguments that are part of the program: hashable, with a complete `repr`. A
            program with one from another package is not cached, since that code may change. Where a program holds
            custom calls of XLA, which only a process that has them registered can run, one of them has their names as
            `custom_calls`.
    """

    def __init__(self, function: Callable[..., Leaves], *, static: tuple[str, ...] = ()):
        update_wrapper(self, function)
        self._function = function
        self.compiled = jax.jit(function, static_argnames=static)  # where nothing is cached
        self._programs: dict[Any, Callable[..., Any]] = {}
        self._tracing = threading.Lock()
        self._compiling: dict[Any, Future[None]] = {}

    def __call__(self, *arguments: Any, **statics: Any) -> Leaves:
        folder = _folder_of(statics)
        if folder is None and not self._compiling:
            return self.compiled(*arguments, **statics)
        key = _key(arguments, statics)
        if compiling := self._compiling.get(key):
            compiling.exception()  # waits; what has failed is tried again
        return self._run(key, folder, arguments, statics)

    def compile_in_background(self, *arguments: Any, **statics: Any) -> None:
        """Start compiling the program for such arguments in a thread; a call with them waits until it is done."""
        key = _key(arguments, statics)

        def work() -> None:
            if _key(arguments, statics) == key:  # else the caller has set up JAX for its own thread only
                self._run(key, _folder_of(statics), arguments, statics)

        if key not in self._programs and key not in self._compiling:
            self._compiling[key] = _BACKGROUND.submit(work)

    def _run(self, key: Any, folder: Path | None, arguments: tuple[Any, ...], statics: dict[str, Any]) -> Leaves:
        if folder is None:
            return self.compiled(*arguments, **statics)
        leaves, structure = jax.tree.flatten(arguments)
        program = self._programs.get(key)
        if program is None:
            with self._tracing:
                path = folder / _file_name(self._function, arguments, statics)
                program = self._programs.get(key) or _program(self._function, structure, leaves, statics, path)
                self._programs[key] = program
        try:
            return tuple(program(*leaves))
        except Exception:  # kept, but it cannot run: JAX says why, or makes it anew
            self._programs[key] = lambda *leaves: self.compiled(*jax.tree.unflatten(structure, leaves), **statics)
            with suppress(OSError):
                (folder / _file_name(self._function, arguments, statics)).unlink(missing_ok=True)
            return self.compiled(*arguments, **statics)


def _key(arguments: tuple[Any, ...], statics: dict[str, Any]) -> Any:
    leaves, structure = jax.tree.flatten(arguments)
    shapes = tuple((np.shape(x), jax.dtypes.result_type(x)) for x in leaves)
    return (os.getpid(), _jax_settings(), structure, shapes, *statics.items())


def _file_name(function: Callable, arguments: tuple[Any, ...], statics: dict[str, Any]) -> str:
    texts = [(n, f"{v.__module__}.{v.__qualname__}" if callable(v) else repr(v)) for n, v in statics.items()]
    calls = tuple(name for value in statics.values() for name in getattr(value, "custom_calls", ()))
    key = map(str, _key(arguments, statics)[1:4])
    known = [function.__module__, function.__qualname__, texts, calls, *key, _made_by()]
    return f"{function.__name__.strip('_')}-{hashlib.sha256(repr(known).encode()).hexdigest()[:32]}"


def _program(function: Callable, structure: Any, leaves: list[Any], statics: dict[str, Any], path: Path) -> Callable:
    with suppress(Exception):  # missing, truncated, of another format: made anew
        return _loaded(zlib.decompress(path.read_bytes()))

    LOG.info("compiling %s into the cache %s", function.__name__.strip("_"), path.parent)

    def flat(*leaves: jax.Array) -> Leaves:
        return function(*jax.tree.unflatten(structure, leaves), **statics)

    # A name of its own, by which JAX does not find it: what its cache has loaded cannot be written whole again.
    flat.__name__ = unique = f"{function.__name__}_{uuid.uuid4().hex}"
    shapes = [jax.ShapeDtypeStruct(np.shape(x), jax.dtypes.result_type(x)) for x in leaves]
    program = jax.jit(flat).lower(*shapes).compile()
    with suppress(OSError):
        for copy in path.parent.parent.glob(f"*{unique}*"):  # JAX's own, that nobody will look for
            copy.unlink()
    with suppress(Exception):  # a full disk, a folder that has gone, a platform that cannot: not cached
        _write(path, zlib.compress(pickle.dumps(serialize_executable.serialize(program)), 1))
    return program


def _loaded(content: bytes) -> Callable:
    """The program that was written, for the first device. It may run any code, as what JAX keeps beside it may."""
    return serialize_executable.deserialize_and_load(*pickle.loads(content), execution_devices=jax.local_devices()[:1])


def _folder_of(statics: dict[str, Any]) -> Path | None:
    """The cache folder, where there is one, programs run on the first device, and the static arguments are of built-in
    types or of this package."""
    modules = (value.__module__ if callable(value) else type(value).__module__ for value in statics.values())
    settings = jax.config.values
    folder = settings["jax_compilation_cache_dir"]
    if not (folder and settings["jax_enable_compilation_cache"]) or "://" in folder:  # a bucket is JAX's own business
        return None
    if settings["jax_disable_jit"] or settings["jax_default_device"] is not None:
        return None
    return Path(folder) / _FOLDER if {m.partition(".")[0] for m in modules} <= {"builtins", "stereorecal"} else None


def _jax_settings() -> tuple[Any, ...]:
    """The settings of JAX that change a program; some may hold in this thread only."""
    return tuple(getattr(jax.config, name, None) for name in _SETTINGS)


@cache
def _made_by() -> tuple[Any, ...]:
    """What programs are made by and for: versions, flags, the device, how many cores XLA spreads them over, which moves
    last bits, and the files of this package."""
    root, devices = Path(__file__).parent, jax.local_devices()
    files = [(str(p.relative_to(root)), p.stat().st_size, p.stat().st_mtime_ns) for p in sorted(root.rglob("*.py"))]
    versions = [*(version(name) for name in ("jax", "jaxlib", "numpy")), devices[0].client.platform_version]
    flags = [os.environ.get(name) for name in _VARIABLES]
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    device = devices[0].platform, devices[0].device_kind, len(devices), cores, _processor()
    return (__version__, *versions, *flags, *device, files)


def _processor() -> str:
    """What this processor can do, or which machine it is in: folders may be shared by several."""
    with suppress(OSError), open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
        return "".join(line for line in islice(file, 40) if line.startswith(("model name", "flags", "Features")))
    return f"{platform.node()} {platform.machine()} {platform.processor()}"


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
