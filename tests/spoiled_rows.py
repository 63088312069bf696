"""Row residuals of a rig whose rows are spoiled in known ways."""

import numpy as np

from stereorecal.recalibration import RowResiduals

PER_TILE, FOCAL = 20, 500.0
COLUMN, ROW = np.meshgrid(np.arange(8), np.arange(6))
X, Y = (2 * COLUMN.ravel() + 1) / 8 - 1, (2 * ROW.ravel() + 1) / 6 - 1


def seen(spoil, start=(0.0,) * 5, noise=0.1, frames=1, seed=0) -> RowResiduals:
    """A rig at `start` degrees and percent from true, whose rows are spoiled by spoil(x, y) pixels, solved.

    Derivatives of the rows as of a rig with a field of view of some 60 degrees: pitch, yaw, roll, y, z.
    """
    rng = np.random.default_rng(seed)
    tile = np.repeat(np.arange(frames * 48), PER_TILE)
    x, y = X[tile % 48] + rng.uniform(-0.1, 0.1, tile.size), Y[tile % 48] + rng.uniform(-0.1, 0.1, tile.size)
    near = rng.uniform(0.02, 0.15, tile.size)  # baselines over depth
    degree, percent = np.radians(1.0) * FOCAL, 0.01 * FOCAL
    u, v = 0.6 * x, 0.45 * y
    jacobian = np.stack([degree * (1 + v * v), degree * u * v, degree * u, percent * near, -percent * near * v], -1)
    target = jacobian @ np.array(start) + spoil(x, y) + rng.normal(0, noise, tile.size)
    weight = np.full(tile.size, 0.5 / noise**2)
    z = -np.linalg.solve(jacobian.T @ (weight[:, None] * jacobian) + np.eye(5), jacobian.T @ (weight * target))
    return RowResiduals(residual=target + jacobian @ z, start_residual=target, tile=tile, independent=0.5)


def nothing(x, y):
    return 0.0 * x
