"""Tensors from a file that `torch.save` wrote, without torch and without running what a pickle may ask for.

Such a file is a zip archive: a pickle of names and shapes (`data.pkl`), and the numbers, one member a storage. A pickle
may call any function that it names; this one may name four things, none of which does more than build an array.
"""

import io
import math
import os
import pickle
import zipfile
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from jaxtyping import Shaped

_TYPES = {"FloatStorage": "<f4", "DoubleStorage": "<f8", "HalfStorage": "<f2", "LongStorage": "<i8"}
_MOST = 1 << 28  # bytes of a member: larger ones are no weights of a small network

Tensor = Shaped[np.ndarray, "..."]


class _Refused(ValueError):
    """With a sentence of ours."""


def read_tensors(path: str | os.PathLike[str]) -> dict[str, Tensor]:
    """The tensors of a state dictionary, by name.

    Raises:
        ValueError: if the file is no such archive, is damaged, or its pickle names anything but tensors.
        FileNotFoundError: if there is none.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            found = _Unpickler(archive).load()
    except (_Refused, FileNotFoundError):
        raise
    except Exception as error:  # whatever a damaged pickle or archive leads to
        raise _Refused(f"{path}: not a file of tensors that torch wrote, or damaged ({error!r})") from error
    if not isinstance(found, Mapping) or not all(isinstance(tensor, np.ndarray) for tensor in found.values()):
        raise _Refused(f"{path}: holds something else than tensors by name")
    return {str(name): tensor for name, tensor in found.items()}


class _Unpickler(pickle.Unpickler):
    """Knows nothing but tensors."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        names = [name for name in archive.namelist() if name.endswith("/data.pkl")]
        if len(names) != 1:
            raise _Refused(f"{archive.filename}: not a file of tensors that torch wrote")
        self._archive, self._folder = archive, names[0].removesuffix("data.pkl")
        super().__init__(io.BytesIO(self._member("data.pkl")))

    def find_class(self, module_name: str, global_name: str) -> Callable[..., Any] | str:
        """Raises: ValueError: for any name but those of a tensor."""
        if (module_name, global_name) == ("collections", "OrderedDict"):
            return OrderedDict
        if (module_name, global_name) == ("torch._utils", "_rebuild_tensor_v2"):
            return lambda *parts: _tensor(*parts)  # one of its own each time: a pickle may set attributes
        if module_name == "torch" and global_name in _TYPES:
            return _TYPES[global_name]
        raise _Refused(f"{self._archive.filename}: names {module_name}.{global_name}, which is no tensor; not read")

    def persistent_load(self, pid: Any) -> Tensor:
        """The numbers of a storage, (n,).

        Raises:
            ValueError: if it is no storage of a known type.
        """
        match pid:
            case ("storage", str(numbers), str(key), _, _) if numbers in _TYPES.values():
                return np.frombuffer(self._member(f"data/{key}"), numbers)
        raise _Refused(f"{self._archive.filename}: names a storage that is none; not read")

    def _member(self, name: str) -> bytes:
        if self._archive.getinfo(self._folder + name).file_size > _MOST:
            raise _Refused(f"{self._archive.filename}: {name} is too large for the weights of a small network")
        return self._archive.read(self._folder + name)


def _tensor(storage: Any, offset: Any, shape: Any, strides: Any, *_: Any) -> Tensor:
    """A copy of the part of a storage that a tensor is. Strides count numbers, not bytes.

    All comes from the pickle, which may hand over the result of another call, or a shape that is no number.
    """
    if type(storage) is not np.ndarray or storage.ndim != 1 or not storage.flags.c_contiguous:
        raise _Refused("a tensor is not of a storage")
    if type(shape) is not tuple or type(strides) is not tuple or len(shape) != len(strides):
        raise _Refused("a tensor has no shape")
    if any(type(number) is not int or number < 0 for number in (offset, *shape, *strides)):
        raise _Refused("a tensor reaches beyond its numbers, or is placed by what is no number")
    last = offset + sum((size - 1) * step for size, step in zip(shape, strides, strict=True))
    count = math.prod(shape)
    if count > len(storage) or (count and last >= len(storage)):
        raise _Refused("a tensor reaches beyond its numbers")
    steps = [step * storage.itemsize for step in strides]
    if not count:
        return np.zeros(shape, storage.dtype)
    return np.lib.stride_tricks.as_strided(storage[offset:], shape, steps).copy()
