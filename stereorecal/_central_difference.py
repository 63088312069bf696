"""Derivatives of functions without a closed form."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float


def central_difference(function: Callable[[float], Float[np.ndarray, "*s"]], step: float) -> Float[np.ndarray, "*s"]:
    """The derivative of a function of one number at 0, to second order in the step."""
    return (function(step) - function(-step)) / (2.0 * step)


def central_differences(
    function: Callable[[Float[np.ndarray, "n"]], Float[np.ndarray, "*s"]], at: Float[np.ndarray, "n"], step: float
) -> Float[np.ndarray, "*s n"]:
    """The derivatives of a function of n numbers."""
    axes = np.eye(len(at))
    return np.stack([central_difference(lambda h, axis=axis: function(at + h * axis), step) for axis in axes], axis=-1)
