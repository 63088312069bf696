"""stereorecal's SAD search in C++, as a custom call of XLA on CPUs: the same integers as `winners_by_rows`."""

import ctypes
import re
from pathlib import Path

import jax.ffi


def register_sad() -> None:
    """Register the custom call `stereorecal_sad_winners`; again does no harm.

    Raises:
        ImportError: if the library is not there, or was built for a later JAX than the one that runs.
    """
    library = ctypes.CDLL(str(_library()))
    built, runs = ctypes.c_int.in_dll(library, "stereorecal_ffi_version").value, _ffi_version()
    if built > runs:  # JAX would accept it, and then not find it
        raise ImportError(f"it was built for XLA's FFI 0.{built}, and this JAX has 0.{runs}")
    call = jax.ffi.pycapsule(library.stereorecal_sad_winners)
    jax.ffi.register_ffi_target("stereorecal_sad_winners", call, platform="cpu")


def _library() -> Path:
    """The compiled part: an editable installation keeps it apart from this file."""
    for folder in __path__:
        if (path := Path(folder) / "stereorecal_native.so").exists():
            return path
    raise ImportError("its library was not built")


def _ffi_version() -> int:
    header = Path(jax.ffi.include_dir()) / "xla/ffi/api/c_api.h"
    found = re.search(r"#define XLA_FFI_API_MINOR (\d+)", header.read_text())
    return int(found[1]) if found else 0
