"""What a matcher gets wrong in a simulated frame: cells without a match, errors of the others, and how sure it is."""

import cv2
import numpy as np

from stereorecal.scoring import TILES


def unmatched(columns: int, rows: int, rng: np.random.Generator) -> np.ndarray:
    """Where nothing is matched: 10 to 50 % of the cells, in patches."""
    patches = _smooth_field(columns, rows, 10, 7, rng) + 0.3 * rng.normal(size=columns * rows)
    return patches < np.quantile(patches, rng.uniform(0.1, 0.5))


def matching_errors(columns: int, rows: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the right pixels (n, 2), and the variances of their rows (n,) that a matcher believes in."""
    count = columns * rows
    sigma = np.clip(rng.uniform(0.05, 0.09) * np.exp(0.3 * rng.normal(size=count)), 0.04, 0.12)
    error = np.stack([rng.normal(0.0, rng.uniform(0.1, 0.2), count), rng.normal(0.0, sigma)], axis=1)
    for axis in (0, 1):  # what neighbours have in common
        error[:, axis] += rng.uniform(0.02, 0.04) * _smooth_field(columns, rows, *TILES, rng)
    outliers = rng.random(count) < rng.uniform(0.01, 0.03)
    error[outliers] += rng.uniform(-2.0, 2.0, (outliers.sum(), 2))
    return error, sigma**2 * np.exp(0.3 * rng.normal(size=count))


def _smooth_field(columns: int, rows: int, across: int, down: int, rng: np.random.Generator) -> np.ndarray:
    """A smooth random field of variance 1 over the cells, `across` times `down` bumps, (rows * columns,)."""
    coarse = rng.normal(size=(down + 3, across + 3)).astype(np.float32)
    fine = cv2.resize(coarse, None, fx=columns / across, fy=rows / down, interpolation=cv2.INTER_CUBIC)
    top, side = int(rng.uniform(1.0, 2.0) * rows / down), int(rng.uniform(1.0, 2.0) * columns / across)
    field = fine[top : top + rows, side : side + columns].astype(float).ravel()
    return field / fine.std()
