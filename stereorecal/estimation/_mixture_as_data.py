"""A mixture of normal distributions as plain data and back, without any rounding."""

from typing import Any

import numpy as np

from stereorecal.estimation._posterior import Posterior

_NOT_POSITIVE = 1e-6  # of the largest eigenvalue of the correlations


def components_of(known: Posterior) -> list[dict[str, Any]]:
    """Of each its weight, its mean, and the rows of its covariance up to the diagonal."""
    return [
        {
            "weight": float(weight),
            "mean": mean.tolist(),
            "covariance": [row[: end + 1].tolist() for end, row in enumerate(covariance)],
        }
        for weight, mean, covariance in zip(known.weights, known.means, known.covariances, strict=True)
    ]


def mixture_from(components: Any, dim: int) -> Posterior:
    """The inverse.

    Args:
        dim: n, the number of parameters.

    Raises:
        KeyError, TypeError, ValueError: if these are none.
    """
    weights = np.array([one["weight"] for one in components], float)
    means = np.array([one["mean"] for one in components], float)
    covariances = np.stack([_covariance(one["covariance"], dim) for one in components])
    if means.shape != (len(weights), dim) or not (np.isfinite(means).all() and np.isfinite(weights).all()):
        raise ValueError("means of another size, or not finite")
    if weights.min() <= 0.0 or not np.isclose(weights.sum(), 1.0, rtol=0.0, atol=1e-9):
        raise ValueError("weights do not sum to 1")
    return Posterior(weights, means, covariances)


def _covariance(rows: Any, dim: int) -> np.ndarray:
    if [len(row) for row in rows] != list(range(1, dim + 1)):
        raise ValueError("a covariance of another size")
    half = np.zeros((dim, dim))
    half[np.tril_indices(dim)] = np.concatenate(rows)
    covariance = half + np.tril(half, -1).T
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(scale > 0.0, scale, 1.0)
    if not np.isfinite(covariance).all() or np.diag(covariance).min() < 0.0:
        raise ValueError("a matrix that is no covariance")
    values = np.linalg.eigvalsh(covariance / safe[:, None] / safe)
    if values.min() < -_NOT_POSITIVE * max(values.max(), 1.0):
        raise ValueError("a covariance that is not positive")
    return covariance
