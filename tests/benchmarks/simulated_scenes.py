"""Simulated scenes without images: how far away is what a camera sees, and what a matcher gets wrong there: cells
without a match, errors of the others, and how sure it is. Drawn anew for each generator."""

import cv2
import numpy as np

from stereorecal.scoring import TILES


def inverse_depth(shown: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Inverse depth along rays at depth 1, in 1 / baselines, of a scene made of planes: the nearest one counts."""
    x, y = shown[:, 0], shown[:, 1]
    right, bottom = np.nanquantile(np.abs(x), 0.98), np.nanquantile(np.abs(y), 0.98)
    if rng.random() < 0.25:  # a room
        nearest, farthest = 4.0, rng.uniform(9.0, 15.0)
        walls = [np.full_like(x, 1.0 / rng.uniform(0.7 * farthest, farthest)) + rng.normal(0.0, 0.01) * x]
        for axis, edge in ((x, right), (-x, right), (y, bottom), (-y, bottom)):
            walls.append((axis + rng.normal(0.0, 0.05)) / (edge * rng.uniform(nearest, 10.0)))
    else:
        nearest, farthest = rng.uniform(3.0, 8.0), np.exp(rng.uniform(np.log(30.0), np.log(400.0)))
        walls = [np.full_like(x, 1.0 / farthest)]
        if rng.random() < 0.85:  # the ground, the horizon nearly level
            horizon = rng.normal(0.0, 0.05)
            height = (bottom - horizon) * nearest * rng.uniform(1.0, 1.6)
            walls.append((y - horizon + rng.normal(0.0, 0.05) * x) / height)
        for _ in range(rng.integers(0, 4)):  # facades: planes along or across the view, up to some height
            angle = rng.uniform(-0.5, 0.5) + rng.choice([0.0, np.pi / 2, -np.pi / 2], p=[0.3, 0.35, 0.35])
            plane = (np.sin(angle) * x + np.cos(angle)) / np.exp(
                rng.uniform(np.log(2 * nearest), np.log(0.7 * farthest))
            )
            shows = (x > rng.uniform(-1.2, 0.5) * right) & (x < rng.uniform(-0.5, 1.2) * right)
            walls.append(np.where(shows & (y > -rng.uniform(0.2, 1.5) * bottom), plane, 0.0))
    for _ in range(rng.integers(0, 9)):  # boxes, nearly parallel to the images
        width, height = rng.uniform(0.1, 0.5) * right, rng.uniform(0.1, 0.7) * bottom
        over = (np.abs(x - rng.uniform(-1, 1) * right) < width) & (np.abs(y - rng.uniform(-0.6, 1) * bottom) < height)
        plane = (1.0 + rng.normal(0.0, 0.2) * x) / np.exp(rng.uniform(np.log(nearest), np.log(0.7 * farthest)))
        walls.append(np.where(over, plane, 0.0))
    return np.clip(np.max(walls, axis=0), 1.0 / farthest, 1.0 / nearest)


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
