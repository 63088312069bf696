"""The search of `winners_by_rows` in compiled code, where an installed distribution brings it (`plugins/native`).

An entry point in the group `stereorecal.kernels` has the name of a custom call of XLA, and is a function that registers
it for CPUs. What the call takes and returns is part of its name: another contract needs another name.
"""

import logging
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Int

from stereorecal._plugins import entry_points
from stereorecal.matching._matcher import AbstractMatcher
from stereorecal.matching.sad._stream import Winners

CALL = "stereorecal_sad_winners"
LOG = logging.getLogger("stereorecal")


@cache
def has_kernel() -> bool:
    """Whether the custom call is registered in this process. One that cannot be loaded is reported, and not used."""
    for point in entry_points(group="stereorecal.kernels").select(name=CALL):
        try:
            point.load()()
        except Exception as error:
            LOG.warning("the compiled search of %s is not used (%r); reinstall or remove it.", point.value, error)
        else:
            return True
    return False


def winners_by_kernel(
    left: Int[jax.Array, "h w"], right: Int[jax.Array, "h w"], options: AbstractMatcher, largest_cost: int
) -> Winners:
    """What `winners_by_rows` returns, integer for integer; `from_right` in any case.

    The call: two images (…, h, w) int16; min_disparity, num_disparities, block_size, uniqueness_ratio and largest_cost
    (of any window) as int64; the fields of `Winners`, (…, h, w) int32.
    """
    lowest, count = options.disparity_range(left.shape[1])
    call = jax.ffi.ffi_call(
        CALL, [jax.ShapeDtypeStruct(left.shape, jnp.int32)] * len(Winners._fields), vmap_method="broadcast_all"
    )
    numbers = {
        "min_disparity": lowest,
        "num_disparities": count,
        "block_size": options.block_size,
        "uniqueness_ratio": options.uniqueness_ratio,
        "largest_cost": largest_cost,
    }
    attributes = {name: np.int64(value) for name, value in numbers.items()}
    return Winners(*call(left, right, **attributes))
