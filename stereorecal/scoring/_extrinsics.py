"""Extrinsics as pure scores take them."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig


def checked_extrinsics(extrinsics: Any) -> Float[jax.Array | np.ndarray, "6"]:
    """The extrinsics of one candidate, (6,).

    Raises:
        InputError: if they are something else.
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
