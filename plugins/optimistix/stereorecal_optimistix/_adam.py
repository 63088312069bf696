"""Adam, in a form that equinox compares fast."""

import jax
import optax

# Equinox compares bare functions by their source code, at every step (10 ms); a Partial it compares directly.
ADAM = optax.GradientTransformationExtraArgs(*map(jax.tree_util.Partial, optax.adam(1.0)))
