"""What is known of θ: a mixture of normal distributions, one for each explanation that the data leave."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, eq=False)
class Posterior:
    """A mixture of m normal distributions of θ (n,).

    Attributes:
        weights: (m,) probabilities, which sum to 1.
        means: (m, n).
        covariances: (m, n, n).
    """

    weights: Float[np.ndarray, "m"]
    means: Float[np.ndarray, "m n"]
    covariances: Float[np.ndarray, "m n n"]

    @cached_property
    def mean(self) -> Float[np.ndarray, "n"]:
        """Of θ."""
        return self.weights @ self.means

    @cached_property
    def covariance(self) -> Float[np.ndarray, "n n"]:
        """Of θ, what the explanations differ by included."""
        apart = self.means - self.mean
        return np.einsum("m,mij->ij", self.weights, self.covariances) + (self.weights * apart.T) @ apart

    def samples(self, number: int, seed: int = 0) -> Float[np.ndarray, "s n"]:
        """θ drawn at random; the same for a seed."""
        draw = np.random.default_rng(seed)
        chosen = draw.choice(len(self.weights), number, p=self.weights)
        normal = draw.standard_normal((number, self.means.shape[1]))
        found = np.empty_like(normal)
        for index in np.unique(chosen):
            here = chosen == index
            found[here] = self.means[index] + normal[here] @ root(self.covariances[index]).T
        return found


def root(covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """S with S Sᵀ = covariance, which may be singular; scaled first, since units differ by orders of magnitude."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(scale > 0.0, scale, 1.0)
    values, axes = np.linalg.eigh(covariance / safe[:, None] / safe)
    return scale[:, None] * axes * np.sqrt(np.maximum(values, 0.0))
