"""Epipolar residuals: the row differences of the two rays of each correspondence under given extrinsics."""

import jax
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Extrinsics, is_host, namespace
from stereorecal.geometry import projection, rectifying_rotations, rotation_from_euler
from stereorecal.scoring._correspondences import Correspondences
from stereorecal.scoring._pure_arguments import checked_extrinsics

SMALLEST_SPREAD = 0.05  # pixels; matching is never better than that


def row_differences(found: Correspondences, extrinsics: Float[AnyArray, "6"]) -> Float[AnyArray, "k m"]:
    """Row in the rectified left image less the row in the rectified right one, in pixels of the scale of `found`.

    Pure; composes under `jit`, `vmap` over the extrinsics, `grad` and `jacfwd`. Where nothing was found
    (`found.weight` is 0) the value is meaningless.

    Args:
        found: what `correspondences` returned.
        extrinsics: (6,): pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.

    Returns:
        (k, m); NumPy in float64 if both arguments are NumPy's, else JAX in float32.
    """
    extrinsics = checked_extrinsics(extrinsics)
    if is_host(*jax.tree.leaves(found), extrinsics):
        return differences_of(found, extrinsics)
    return _compiled(found, extrinsics)


def differences_of(found: Correspondences, extrinsics: Extrinsics) -> Float[AnyArray, "k m"]:
    """`row_differences` (k, m), for callers that compile it as a part of their own program."""
    xp = namespace(found.left, extrinsics)
    first, second = rectifying_rotations(rotation_from_euler(extrinsics[:3]), extrinsics[3:])

    def rows(rays, rotation):
        x, y, z = rays[..., 0], rays[..., 1], rays[..., 2]  # written out: a GPU would multiply matrices with ten bits
        (a, b, c), (d, e, f) = rotation[1], rotation[2]
        return row(a * x + b * y + c * z, d * x + e * y + f * z)

    row = projection(found.projection).row
    return xp.asarray(found.focal) * (rows(found.left, first) - rows(found.right, second))


# `checkpoint`: in reverse mode, to keep some seventy small factors of the derivative takes longer than to compute them.
_compiled = jax.jit(jax.checkpoint(differences_of))


def median_row_error(found: Correspondences, extrinsics: Extrinsics) -> float:
    """Median |row difference| in pixels at full size; NaN if nothing was found."""
    valid = np.asarray(found.weight) > 0
    differences = row_differences(found, extrinsics)
    return float(np.median(np.abs(differences[valid])) / float(found.scale)) if valid.any() else float("nan")
