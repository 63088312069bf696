"""The ground plane y = 0: a band-limited texture as a sum of octaves, and a map of shade."""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._noise import Texture, tile_at, wrapped

_MAP_NEAR = 3.0  # [m]: the shade map covers z >= 3 m and |x| <= z, which is more than the default rig sees
_MAP_SIZE = (1280, 512)  # columns, rows: about a pixel of the default rig each


@dataclass(frozen=True, eq=False)
class Octaves:
    """Octaves of a periodic texture on the ground plane.

    Attributes:
        tile: (n + 1, n + 1) or (n + 1, n + 1, c) float32, `wrapped`.
        waves: wavelengths across the tile.
        lengths: wavelength [m] of each octave.
        strengths: amplitude of each octave.
        turns: rotation [rad] of each octave.
        offsets: (k, 2) shift of each octave, in tiles.
    """

    tile: Float[np.ndarray, "n n *c"]
    waves: float
    lengths: tuple[float, ...]
    strengths: tuple[float, ...]
    turns: tuple[float, ...]
    offsets: Float[np.ndarray, "k 2"]

    def at(self, x, z, footprint, shifts=None):
        """Yield the rotation and the values (h, w, c) of each octave at ground points x, z [m].

        An octave fades out where its wavelength nears the footprint [m] of the ray, as the sampling theorem demands:
        full strength from 3 footprints on, none below 4/3. `shifts` (k, 2) [m] moves the octaves.
        """
        for index, (length, strength, turn) in enumerate(zip(self.lengths, self.strengths, self.turns, strict=True)):
            fade = np.clip(length / footprint * np.float32(0.6) - np.float32(0.8), 0.0, 1.0)
            if not fade.any():
                continue
            scale = 1.0 / (length * self.waves)
            cos, sin = np.float32(np.cos(turn) * scale), np.float32(np.sin(turn) * scale)
            start = self.offsets[index] + (0.0 if shifts is None else shifts[index] * scale)
            u = cos * x + sin * z + np.float32(start[0])
            v = cos * z - sin * x + np.float32(start[1])
            yield turn, tile_at(self.tile, u, v).reshape(*x.shape, -1) * (np.float32(strength) * fade)[..., None]


def octaves(rng, tile, waves, longest, strengths, spread_of_turns) -> Octaves:
    """Octaves with wavelengths from `longest` [m] downwards, each 0.47 times the one before.

    Not half of it, so that the periods do not line up. Each is rotated by up to `spread_of_turns` [rad] either way.
    """
    count = len(strengths)
    lengths = tuple(float(longest * 0.47**i) for i in range(count))
    turns = tuple(float(t) for t in rng.uniform(-spread_of_turns, spread_of_turns, count))
    return Octaves(wrapped(tile), waves, lengths, tuple(strengths), turns, rng.uniform(0.0, 1.0, (count, 2)))


class Stain(NamedTuple):
    """A convex polygon (n, 2) of ground points (x, z) [m] within which the light is multiplied by `factor`."""

    outline: Float[np.ndarray, "n 2"]
    factor: float


def shade_map(stains: list[Stain], blur: tuple[float, float]) -> Texture:
    """Product of the factors of all stains, a map over x/z and 1/z: as fine near as far, as an image is.

    `blur` is the sigma (across, along) in texels.
    """
    columns, rows = _MAP_SIZE
    shade = np.ones((rows, columns), np.float32)
    for stain in stains:
        outline = _clipped(stain.outline)
        if len(outline) < 3:
            continue
        u = (0.5 + 0.5 * outline[:, 0] / outline[:, 1]) * columns
        v = _MAP_NEAR / outline[:, 1] * rows
        mask = np.zeros((rows, columns), np.uint8)
        corners = np.clip(np.stack([u, v], -1) * 16, -1e6, 1e6).round().astype(np.int32)
        cv2.fillConvexPoly(mask, corners, 255, lineType=cv2.LINE_AA, shift=4)
        shade *= 1.0 - (1.0 - stain.factor) * (mask.astype(np.float32) / 255.0)
    return cv2.GaussianBlur(shade, (0, 0), sigmaX=blur[0], sigmaY=blur[1])


def shade_at(shade: Texture, x, z) -> Texture:
    """Values of the shade map at ground points x, z [m]."""
    rows, columns = shade.shape
    inverse = 1.0 / np.maximum(z, _MAP_NEAR)
    u = (0.5 + 0.5 * x * inverse) * np.float32(columns)
    v = np.float32(_MAP_NEAR * rows) * inverse
    return cv2.remap(shade, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _clipped(outline: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "_ 2"]:
    """The polygon clipped to z >= _MAP_NEAR."""
    kept = []
    for p, q in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if p[1] >= _MAP_NEAR:
            kept.append(p)
        if (p[1] >= _MAP_NEAR) != (q[1] >= _MAP_NEAR):
            kept.append(p + (q - p) * ((_MAP_NEAR - p[1]) / (q[1] - p[1])))
    return np.array(kept).reshape(-1, 2)
