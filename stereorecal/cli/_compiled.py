"""Compiled programs are kept in the user's cache folder: a first repair takes most of its time to compile."""

import os
import warnings

import jax
from platformdirs import user_cache_path

_LEAST_SECONDS = 0.1  # of compiling; what is faster is not worth a file


def keep_compiled_programs() -> None:
    """Use JAX's persistent compilation cache, unless the user has set one up, has switched it off
    (`JAX_ENABLE_COMPILATION_CACHE=false`), or cannot write to the folder.

    A repair leaves some forty files of 30 kB for each image size and each of the few disparity ranges.
    """
    settings = jax.config.values
    if not settings["jax_enable_compilation_cache"] or settings["jax_compilation_cache_dir"] is not None:
        return
    try:
        folder = user_cache_path("stereorecal") / "programs"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # a user without a home
        return
    if os.access(folder, os.W_OK):
        jax.config.update("jax_compilation_cache_dir", str(folder))
        if "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS" not in os.environ:
            jax.config.update("jax_persistent_cache_min_compile_time_secs", _LEAST_SECONDS)
        # A file that a full disk cut short costs a compilation, not a line for the user.
        warnings.filterwarnings("ignore", message="Error (reading|writing) persistent compilation cache entry")
