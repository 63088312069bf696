"""What is known of θ: a mixture of normal distributions, one for each explanation that the data leave."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

_SINGULAR = 1e-12  # of the largest eigenvalue
_ROUNDING = 1e-12  # of the squares whose difference is taken


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
        deviations = self.means - self.mean
        return np.einsum("m,mij->ij", self.weights, self.covariances) + (self.weights * deviations.T) @ deviations

    def samples(self, number: int, seed: int = 0) -> Float[np.ndarray, "s n"]:
        """θ drawn at random, the same for a seed; each explanation has its share of them, to one draw."""
        draw, ends = np.random.default_rng(seed), np.cumsum(self.weights)
        chosen = np.searchsorted(ends[:-1] / ends[-1], (np.arange(number) + 0.5) / number)
        normal = draw.standard_normal((number, self.means.shape[1]))
        found = np.empty_like(normal)
        for index in np.unique(chosen):
            drawn = chosen == index
            found[drawn] = self.means[index] + normal[drawn] @ root(self.covariances[index]).T
        return found


def median_and_interval(samples: Float[np.ndarray, "s *p"]) -> Float[np.ndarray, "3 *p"]:
    """Median, and the two ends of the 95 % interval."""
    return np.percentile(samples, [50.0, 2.5, 97.5], axis=0)


def merged(posterior: Posterior, most: int) -> Posterior:
    """The posterior with so many explanations at most: those that are alike in all that is uncertain become one, which
    leaves mean and covariance as they are, and of all quantiles what samples tell."""
    w, means, covariances = posterior.weights, posterior.means, posterior.covariances
    if len(w) <= most:
        return posterior
    if most == 1:
        return Posterior(np.ones(1), posterior.mean[None], posterior.covariance[None])
    white = _whitening(posterior.covariance)
    shapes = (white @ covariances @ white.T).reshape(len(w), -1) / np.sqrt(2.0)
    features = np.concatenate([(means - posterior.mean) @ white.T, shapes], axis=1)
    size = np.sum(features**2, axis=1)

    def distance_from(index: int) -> Float[np.ndarray, "m"]:
        squares = size + size[index]
        distance = squares - 2.0 * (features @ features[index])
        return np.where(distance <= _ROUNDING * squares, 0.0, distance)  # the same, but for rounding, are one

    # One centre after the other where most weight is farthest from all others.
    heaviest = int(w.argmax())
    nearest, group = distance_from(heaviest), np.zeros(len(w), int)
    for number in range(1, most):
        other = distance_from(index := int((w * nearest).argmax()))
        other[index] = 0.0
        group, nearest = np.where(other < nearest, number, group), np.minimum(other, nearest)
    belongs = (group == np.unique(group)[:, None]) * w
    weights = belongs.sum(axis=1)
    share = belongs / weights[:, None]
    centres = share @ means
    spread = means - centres[np.unique(group, return_inverse=True)[1]]
    whole = covariances + spread[:, :, None] * spread[:, None, :]
    return Posterior(weights, centres, np.tensordot(share, whole, 1))


def _whitening(covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "r n"]:
    """What makes a covariance the identity, in the directions that are uncertain."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    inverse = np.where(scale > 0.0, 1.0 / np.where(scale > 0.0, scale, 1.0), 0.0)
    values, axes = np.linalg.eigh(covariance * inverse[:, None] * inverse)
    uncertain = values > _SINGULAR * max(values.max(initial=0.0), _SINGULAR)
    return (axes[:, uncertain] / np.sqrt(values[uncertain])).T * inverse


def root(covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """S with S Sᵀ = covariance, which may be singular; scaled first, since units differ by orders of magnitude. The
    symmetric one of what is scaled, since it is unique: samples do not change with the processor."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(scale > 0.0, scale, 1.0)
    values, axes = np.linalg.eigh(covariance / safe[:, None] / safe)
    return scale[:, None] * ((axes * np.sqrt(np.maximum(values, 0.0))) @ axes.T)
