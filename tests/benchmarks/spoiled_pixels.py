"""Ways in which the right images of a simulated rig are spoiled, told by where their pixels end up.

region: a part of the image is moved by 0.5 to 2 rows, the same part and rows in all frames.
late: the right image is late on a vehicle that moves.
shutter: rows shift linearly from top to bottom, by another amount in each frame.
stretch: the image is stretched vertically, the same in all frames.
"""

import numpy as np

from stereorecal.geometry import rotation_from_euler

SPOILS = ("region", "late", "shutter", "stretch")


class Spoiled:
    """What is wrong with the right images of one rig.

    Args:
        kind: one of SPOILS, or None: nothing is.
        size: of the images.
        baseline: the rig's [m].

    Raises:
        ValueError: if there is no such kind.
    """

    def __init__(self, kind: str | None, rng: np.random.Generator, size: tuple[int, int], baseline: float) -> None:
        if kind is not None and kind not in SPOILS:
            raise ValueError(f"{kind!r} is none of {SPOILS}")
        self._kind, self._rng, self._baseline = kind, rng, baseline
        self._size = np.array(size, float)
        self._stretch = rng.choice([-1.0, 1.0]) * rng.uniform(0.001, 0.005)
        self._rows = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0)
        share, place = rng.uniform(0.2, 0.5), rng.choice(4)
        wide = rng.uniform(share, min(1.0, share / 0.4))
        # Left, right, top, or a rectangle: from, to, in shares of the width and the height.
        corner = rng.uniform(0.0, 1.0, 2) * (1.0 - np.array([wide, share / wide]))
        self._region = [
            ((0.0, 0.0), (share, 1.0)),
            ((1.0 - share, 0.0), (1.0, 1.0)),
            ((0.0, 0.0), (1.0, share)),
            (corner, (corner[0] + wide, corner[1] + share / wide)),
        ][place]

    def frame(self, points: np.ndarray, where: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A frame's points (n, 3) as the right camera sees them, and how far its pixels are moved (n, 2)."""
        shift = np.zeros((len(points), 2))
        self._shutter = self._rng.choice([-1.0, 1.0]) * self._rng.uniform(0.3, 2.0)
        advance, turn = self._rng.uniform(0.05, 0.5), self._rng.uniform(-0.3, 0.3, 3) / np.sqrt(3.0)
        if self._kind == "region":
            start, end = (np.array(corner) * self._size for corner in self._region)
            shift[((where >= start) & (where <= end)).all(axis=1), 1] = self._rows
        elif self._kind == "late":
            points = (points - [0.0, 0.0, advance * self._baseline]) @ rotation_from_euler(np.radians(turn)).T
        return points, shift

    def bent(self, pixels: np.ndarray) -> np.ndarray:
        """Where the right pixels of this frame end up."""
        height, rows = self._size[1], pixels[:, 1]
        moved = {"shutter": self._shutter * rows / height, "stretch": self._stretch * (rows - 0.5 * (height - 1.0))}
        return pixels + np.column_stack([0.0 * rows, moved.get(self._kind or "", 0.0 * rows)])
