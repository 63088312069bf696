"""Checks of the arguments of the pure scores: the extrinsics of one candidate, and the matcher."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.matching import AbstractMatcher, as_matcher


def checked_extrinsics(extrinsics: Any) -> Float[jax.Array | np.ndarray, "6"]:
    """The extrinsics of one candidate, (6,).

    Raises:
        InputError: if they are a rig, or have another shape.
    """
    if isinstance(extrinsics, StereoRig):
        raise InputError("the extrinsics are a rig; give rig.extrinsics.")
    if not isinstance(extrinsics, jax.Array | np.ndarray):
        extrinsics = np.asarray(extrinsics, float)
    if jnp.shape(extrinsics) != (6,):
        raise InputError(
            f"the extrinsics have shape {jnp.shape(extrinsics)}, not (6,): pitch, yaw, roll [rad], x, y, z [m]; for "
            "many candidates, use jax.vmap over them."
        )
    return extrinsics


def pure_matcher(matcher: AbstractMatcher | str, scale: float, score: str, *, smooth: bool = False) -> AbstractMatcher:
    """The matcher at an image scale, if the pure function called `score` can use it.

    Raises:
        InputError: if it runs on the host, is not smooth where it must be, or its disparity range is not known.
    """
    matcher = as_matcher(matcher)
    name = type(matcher).__name__
    if not (matcher.smooth if smooth else matcher.traceable):
        raise InputError(
            f"{score} needs a matcher in JAX{' with a differentiable twin' if smooth else ''}, and {name} is none; "
            "use sr.SAD(...), or sr.score, which takes every matcher."
        )
    if matcher.num_disparities is None:
        raise InputError(
            f"{score} needs to know the disparity range; give num_disparities, as in sr.{name}(num_disparities=96), or "
            "have it measured: sr.with_disparity_range(matcher, rig, pairs)."
        )
    return matcher.scaled(scale)
