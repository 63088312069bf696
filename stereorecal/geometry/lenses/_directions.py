"""What wide models share: directions, and where their images end."""

from types import ModuleType
from typing import Any

import jax.numpy as jnp
import numpy as np

from stereorecal._arrays import is_host, namespace
from stereorecal.geometry.lenses._model import FLAT_LIMIT


def in_kind(points: Any, coefficients: Any) -> tuple[ModuleType, Any]:
    """`numpy` and float64, or `jax.numpy` and float32, if any of the two is of JAX."""
    if is_host(points, coefficients):
        return np, np.asarray(points, float)
    return jnp, jnp.asarray(points, jnp.float32)


def unit(x: Any, y: Any, z: Any, seen: Any) -> Any:
    """Unit vectors, NaN where nothing is seen."""
    xp = namespace(x, y, z)
    length = xp.sqrt(x * x + y * y + z * z)
    return xp.where(seen[..., None], xp.stack([x, y, z], axis=-1) / length[..., None], xp.nan)


def flat(field: float) -> float:
    """The tangent of an angle off the axis, FLAT_LIMIT at most."""
    return FLAT_LIMIT if field >= np.arctan(FLAT_LIMIT) else float(np.tan(field))


def steepest(alpha: float) -> float:
    """The cosine, of the angle behind the second centre, at which image points turn back."""
    return alpha / (1.0 - alpha) if alpha <= 0.5 else (1.0 - alpha) / alpha
