"""JAX as the commands use it: with the compilation cache in the user's cache folder, on a platform that exists.

A first repair takes most of its time to compile.
"""

import os
import warnings
from pathlib import Path

import jax
from platformdirs import user_cache_path

from stereorecal._errors import InputError

_LEAST_SECONDS = 0.1  # of compiling; what is faster is not worth a file
_ELSEWHERE = "every command will compile again, for some ten seconds; set JAX_COMPILATION_CACHE_DIR to another folder"


def use_compile_cache() -> str | None:
    """Use JAX's persistent compilation cache, unless the user has switched it off
    (`JAX_ENABLE_COMPILATION_CACHE=false`): some ten files of 20 to 140 kB for each image size and disparity range.
    Returns a sentence for the user if that fails."""
    settings = jax.config.values
    if not settings["jax_enable_compilation_cache"]:
        return None
    configured = settings["jax_compilation_cache_dir"]
    if configured is not None and "://" in configured:  # the address of a bucket: JAX's own business
        return None
    try:
        folder = user_cache_path("stereorecal") / "programs" if configured is None else Path(configured)
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(None, "not writable", str(folder))
    except (OSError, RuntimeError) as error:  # RuntimeError: a user without a home
        jax.config.update("jax_enable_compilation_cache", False)
        why = f"{error.filename}: {error.strerror}" if isinstance(error, OSError) else error
        return f"compiled programs cannot be cached ({why}); {_ELSEWHERE}."
    if configured is None:
        jax.config.update("jax_compilation_cache_dir", str(folder))
    if "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS" not in os.environ:
        jax.config.update("jax_persistent_cache_min_compile_time_secs", _LEAST_SECONDS)
    # A file truncated by a full disk costs one compilation; no warning is needed.
    warnings.filterwarnings("ignore", message="Error (reading|writing) persistent compilation cache entry")
    return None


def set_up_platform() -> None:
    """Refuse a platform that `JAX_PLATFORMS` names and this machine, or this installation of JAX, does not have. Of a
    GPU's memory a process takes what it needs, and not most of it at once: workers share it."""
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    if not (platforms := os.environ.get("JAX_PLATFORMS")):
        return
    try:
        jax.devices()
    except Exception as error:  # an AssertionError, a RuntimeError, whatever a plug-in of JAX raises
        why = str(error).partition("\n")[0] or "it is not there"
        raise InputError(
            f"JAX_PLATFORMS is {platforms!r}, which JAX cannot use here ({why}); leave it out, or install what it "
            "needs, such as pip install 'jax[cuda12]' for NVIDIA's."
        ) from error
