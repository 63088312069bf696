"""What a GPU would be given to compute, computed here."""

from collections.abc import Callable
from functools import cache

import jax
import jax.numpy as jnp
from jax import export

from stereorecal.matching import SAD, Disparity


@cache
def as_on_a_gpu(matcher: SAD, shape: tuple[int, int]) -> Callable[..., Disparity]:
    """`matcher.match` of images of this shape, as it is lowered for CUDA."""
    image = jax.ShapeDtypeStruct(shape, jnp.float32)
    anywhere = [export.DisabledSafetyCheck.platform()]
    lowered = export.export(jax.jit(matcher.match), platforms=["cuda"], disabled_checks=anywhere)(image, image)
    return jax.jit(lowered.call)
