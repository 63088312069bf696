"""What is known of θ, before images and after them: a mixture of normal distributions, one for each explanation."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property, wraps
from typing import Any, TypeVar, cast

import numpy as np
from jaxtyping import Float

_SINGULAR = 1e-12  # of the largest eigenvalue
_ROUNDING = 1e-12  # of the squares whose difference is taken
_NO_COVARIANCE = 1e-6  # of the largest eigenvalue of the correlations

Method = TypeVar("Method", bound=Callable[..., Any])


class Travels:
    """A dataclass that is pickled by its fields alone: what is derived stays behind."""

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}  # pyright: ignore[reportArgumentType]


def remembered(method: Method) -> Method:
    """A method of one argument that is asked the same again and again: what it gave is kept beside the fields."""

    @wraps(method)
    def remembering(self: Any, asked: Any) -> Any:
        given = vars(self).setdefault(f"_given_by_{method.__name__}", {})
        key = asked.tobytes() if isinstance(asked, np.ndarray) else asked
        if key not in given:
            given[key] = method(self, asked)
        return given[key]

    return cast(Method, remembering)


@dataclass(frozen=True, eq=False)
class Mixture(Travels):
    """A mixture of m normal distributions of θ (n,).

    Attributes:
        weights: (m,) probabilities, which sum to 1.
        means: (m, n).
        covariances: (m, n, n).
    """

    weights: Float[np.ndarray, "m"]
    means: Float[np.ndarray, "m n"]
    covariances: Float[np.ndarray, "m n n"]

    @classmethod
    def single(cls, mean: Float[np.ndarray, "n"], covariance: Float[np.ndarray, "n n"]) -> "Mixture":
        """One normal distribution."""
        return cls(np.ones(1), mean[None], covariance[None])

    @cached_property
    def mean(self) -> Float[np.ndarray, "n"]:
        """The mean of θ."""
        return self.weights @ self.means

    @cached_property
    def covariance(self) -> Float[np.ndarray, "n n"]:
        """The covariance of θ, what the explanations differ by included."""
        deviations = self.means - self.mean
        return np.einsum("m,mij->ij", self.weights, self.covariances) + (self.weights * deviations.T) @ deviations

    @cached_property
    def roots(self) -> Float[np.ndarray, "m n n"]:
        """Roots S of the covariances S Sᵀ; read-only."""
        found = np.stack([root(one) for one in self.covariances])
        found.flags.writeable = False
        return found

    def beside(self, other: Float[np.ndarray, "n n"]) -> "Mixture":
        """The mixture with another error of this covariance, independent of it."""
        return replace(self, covariances=self.covariances + other)

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

    def as_data(self) -> list[dict[str, Any]]:
        """The weight of each explanation, its mean, and the rows of its covariance up to the diagonal."""
        return [
            {
                "weight": float(weight),
                "mean": mean.tolist(),
                "covariance": [row[: end + 1].tolist() for end, row in enumerate(covariance)],
            }
            for weight, mean, covariance in zip(self.weights, self.means, self.covariances, strict=True)
        ]

    @staticmethod
    def from_data(components: Any, dim: int) -> "Mixture":
        """The inverse, of `dim` parameters.

        Raises:
            KeyError, TypeError, ValueError: if these are none.
        """
        weights, means = (np.array([one[name] for one in components], float) for name in ("weight", "mean"))
        covariances = np.stack([_covariance(one["covariance"], dim) for one in components])
        if means.shape != (len(weights), dim) or not (np.isfinite(means).all() and np.isfinite(weights).all()):
            raise ValueError("means of another size, or not finite")
        if weights.min() <= 0.0 or not np.isclose(weights.sum(), 1.0, rtol=0.0, atol=1e-9):
            raise ValueError("weights do not sum to 1")
        return Mixture(weights, means, covariances)


def _covariance(rows: Any, dim: int) -> Float[np.ndarray, "n n"]:
    if [len(row) for row in rows] != list(range(1, dim + 1)):
        raise ValueError("a covariance of another size")
    half = np.zeros((dim, dim))
    half[np.tril_indices(dim)] = np.concatenate(rows)
    covariance = half + np.tril(half, -1).T
    if not np.isfinite(covariance).all() or np.diag(covariance).min() < 0.0:
        raise ValueError("a matrix that is no covariance")
    values = np.linalg.eigvalsh(_correlations(covariance)[0])
    if values.min() < -_NO_COVARIANCE * max(values.max(), 1.0):
        raise ValueError("a covariance that is not positive")
    return covariance


def median_and_interval(samples: Float[np.ndarray, "s *p"]) -> Float[np.ndarray, "3 *p"]:
    """Median, and the two ends of the 95 % interval."""
    return np.percentile(samples, [50.0, 2.5, 97.5], axis=0)


def merged(posterior: Mixture, most: int) -> Mixture:
    """The posterior with so many explanations at most: those that are alike in all that is uncertain become one, which
    leaves mean and covariance as they are, and of all quantiles what samples tell."""
    w, means, covariances = posterior.weights, posterior.means, posterior.covariances
    if len(w) <= most:
        return posterior
    if most == 1:
        return Mixture.single(posterior.mean, posterior.covariance)
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
    return Mixture(weights, centres, np.tensordot(share, whole, 1))


def _correlations(covariance: Float[np.ndarray, "n n"]) -> tuple[Float[np.ndarray, "n n"], Float[np.ndarray, "n"]]:
    """Correlations and standard deviations; 0 of what is exact."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(scale > 0.0, scale, 1.0)
    return covariance / safe[:, None] / safe, scale


def _whitening(covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "r n"]:
    """What makes a covariance the identity, in the directions that are uncertain."""
    correlations, scale = _correlations(covariance)
    inverse = np.where(scale > 0.0, 1.0 / np.where(scale > 0.0, scale, 1.0), 0.0)
    values, axes = np.linalg.eigh(correlations)
    uncertain = values > _SINGULAR * max(values.max(initial=0.0), _SINGULAR)
    return (axes[:, uncertain] / np.sqrt(values[uncertain])).T * inverse


def root(covariance: Float[np.ndarray, "n n"]) -> Float[np.ndarray, "n n"]:
    """S with S Sᵀ = covariance, which may be singular; scaled first, since units differ by orders of magnitude. The
    symmetric one of what is scaled, since it is unique: samples do not change with the processor."""
    correlations, scale = _correlations(covariance)
    values, axes = np.linalg.eigh(correlations)
    return scale[:, None] * ((axes * np.sqrt(np.maximum(values, 0.0))) @ axes.T)
