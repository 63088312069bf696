"""The ground plane y = 0, water or a road: a band-limited texture as a sum of octaves, and a map of shade. Albedos,
widths and other constants are chosen to look right.
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._noise import Texture, periodic, tile_at, wave_slopes, wrapped
from stereorecal.synthetic._sky import Sky

_MAP_NEAR = 3.0  # [m]: the shade map covers z >= 3 m and |x| <= z, which is more than the default rig sees
_MAP_SIZE = (1280, 512)  # columns, rows: about a pixel of the default rig each
_WAVES = 12.0  # wavelengths across a tile of the texture
_GRAINS = 24.0  # grains across a tile of the texture


@dataclass(frozen=True, eq=False)
class Octaves:
    """Octaves of a periodic texture on the ground plane."""

    tile: Float[np.ndarray, "n n *c"]  # (n + 1, n + 1) or (n + 1, n + 1, c) float32, `wrapped`
    waves: float  # wavelengths across the tile
    lengths: tuple[float, ...]  # wavelength [m] of each octave
    strengths: tuple[float, ...]  # amplitude of each octave
    turns: tuple[float, ...]  # rotation [rad] of each octave
    offsets: Float[np.ndarray, "k 2"]  # shift of each octave, in tiles

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


@dataclass(frozen=True, eq=False)
class Water:
    """Water with wave normals and Fresnel reflection of the sky."""

    octaves: Octaves  # slopes of the waves
    heading: float  # direction [rad] in which the waves travel
    body: float  # radiance of the water itself, without reflection
    shade: Texture  # map of the reflections of objects, which hide the sky (`shade_map`)

    def radiance(
        self, x: Texture, z: Texture, directions: Float[np.ndarray, "h w 3"], distance, spread, time, sky: Sky
    ) -> Texture:
        """Radiance at ground points x, z [m] seen along unit `directions`; the waves travel with `time` [s]."""
        grazing = np.maximum(-directions[..., 1], np.float32(1e-4))
        footprint = np.float32(spread) * distance / grazing ** np.float32(0.7)
        heading = np.array([np.cos(self.heading), np.sin(self.heading)])
        # Waves in deep water travel at sqrt(g wavelength / 2 pi).
        shifts = [-time * np.sqrt(9.81 * length / 6.283) * heading for length in self.octaves.lengths]
        slope_x, slope_z = np.zeros_like(x), np.zeros_like(x)
        for turn, values in self.octaves.at(x, z, footprint, shifts):
            cos, sin = np.float32(np.cos(turn)), np.float32(np.sin(turn))
            slope_x += cos * values[..., 0] - sin * values[..., 1]
            slope_z += sin * values[..., 0] + cos * values[..., 1]
        dx, dy, dz = (directions[..., i] for i in range(3))
        # The normal is (-slope_x, 1, -slope_z) / length; only its projection on the ray matters.
        inverse = 1.0 / np.sqrt(1.0 + slope_x**2 + slope_z**2)
        cosine = np.maximum((slope_x * dx - dy + slope_z * dz) * inverse, np.float32(0.01))
        up = np.abs(dy + 2.0 * cosine * inverse)
        # Schlick's approximation of Fresnel reflectance; water reflects 2 % at normal incidence.
        mirror = np.float32(0.02) + np.float32(0.98) * (1.0 - np.minimum(cosine, 1.0)) ** 5
        # Waves too fine to be resolved still raise the mean elevation that a grazing ray reflects.
        lift = np.float32(0.12) * np.clip(footprint, 0.0, 1.0)
        push = np.float32(1.0) + np.float32(0.4) * slope_z
        shade = shade_at(self.shade, x + z * slope_x * np.float32(0.12), z * push)
        mirrored = sky.gradient(np.minimum(up + lift, 1.0)) * shade + (1.0 - shade) * np.float32(0.06)
        return mirror * mirrored + (1.0 - mirror) * np.float32(self.body)


def make_water(rng: np.random.Generator, roughness: float, longest: float, body: float, shade: Texture) -> Water:
    """Draw water with waves up to `longest` [m] long; `roughness` is the rms slope of its strongest octaves."""
    heading = rng.uniform(-np.pi, np.pi)
    tile = wave_slopes(rng, 256, _WAVES, heading)
    strengths = [roughness * s for s in (0.7, 0.8, 0.9, 1.0, 1.0, 0.9, 0.8)]
    return Water(octaves(rng, tile, _WAVES, longest, strengths, 0.7), heading, body, shade)


@dataclass(frozen=True, eq=False)
class Road:
    """A straight road along z: asphalt with markings, between two pavements."""

    octaves: Octaves  # grain of asphalt and pavement
    half_width: float  # distance [m] from the centre line to the kerb
    middle: float  # x of the centre line [m]
    light: float  # irradiance of the road
    shade: Texture  # map of the shadows (`shade_map`)

    def radiance(
        self, x: Texture, z: Texture, directions: Float[np.ndarray, "h w 3"], distance, spread, time, sky: Sky
    ) -> Texture:
        """Radiance at ground points x, z [m] seen along unit `directions`; `time` and `sky` affect water only."""
        grazing = np.maximum(-directions[..., 1], np.float32(1e-4))
        footprint = np.float32(spread) * distance / np.sqrt(grazing)
        grain, wear = np.zeros_like(x), np.zeros_like(x)
        for index, (_, values) in enumerate(self.octaves.at(x, z, footprint)):
            grain += values[..., 0]
            if index < 3:
                wear += values[..., 0]
        side = np.abs(x - np.float32(self.middle))
        edge = footprint + np.float32(0.01)
        pavement = _step(side - np.float32(self.half_width), edge)
        tracks = np.cos((side - np.float32(0.45 * self.half_width)) * np.float32(3.6))
        albedo = np.float32(0.17) * (1.0 + np.float32(0.55) * grain - np.float32(0.08) * tracks)
        joints = _lines(x, 0.6, 0.012, edge) + _lines(z, 0.6, 0.012, footprint * 2.0 + np.float32(0.01))
        slabs = np.float32(0.32) * (1.0 + np.float32(0.4) * grain) * (1.0 - np.float32(0.4) * np.minimum(joints, 1))
        albedo += pavement * (slabs - albedo)
        kerb = _band(side, self.half_width, self.half_width + 0.18, edge)
        albedo += kerb * (np.float32(0.42) * (1.0 + np.float32(0.4) * grain) - albedo)
        gutter = _band(side, self.half_width - 0.22, self.half_width, edge)
        albedo *= 1.0 - np.float32(0.35) * gutter
        dash = np.minimum(_lines(z, 9.0, 3.0, footprint * 2.0), 1.0) * _band(side, -0.08, 0.08, edge)
        paint = dash + _band(side, self.half_width - 2.35, self.half_width - 2.23, edge)
        worn = np.clip(0.85 - 1.1 * wear, 0.15, 1.0)
        albedo += np.clip(paint * worn, 0.0, 1.0) * (np.float32(0.62) - albedo)
        return np.clip(albedo, 0.03, 1.0) * np.float32(self.light) * shade_at(self.shade, x, z)


def _step(value: Texture, edge: Texture) -> Texture:
    """Antialiased step from 0 to 1 at value 0, `edge` wide."""
    return np.clip(value / edge + np.float32(0.5), 0.0, 1.0)


def _band(value: Texture, low: float, high: float, edge: Texture) -> Texture:
    """Antialiased 1 between `low` and `high`, 0 elsewhere."""
    return _step(value - np.float32(low), edge) - _step(value - np.float32(high), edge)


def _lines(value: Texture, period: float, width: float, edge: Texture) -> Texture:
    """Antialiased lines of `width` every `period`, fading to their mean where the edge is wider than the period."""
    phase = value - np.float32(period) * np.floor(value / np.float32(period))
    line = _band(np.abs(phase - np.float32(0.5 * period)), -1.0, 0.5 * width, edge)
    fade = np.clip(np.float32(period) / edge - np.float32(1.0), 0.0, 1.0)
    return fade * line + (1.0 - fade) * np.float32(width / period)


def make_road(rng: np.random.Generator, half_width: float, middle: float, light: float, shade: Texture) -> Road:
    """A road with a grain drawn from `rng`."""
    tile = periodic(rng, 256, lambda kx, ky: np.exp(-0.5 * (np.log((np.hypot(kx, ky) + 1e-9) / _GRAINS) / 0.5) ** 2))
    strengths = (0.16, 0.14, 0.14, 0.14, 0.16, 0.2, 0.24, 0.24)
    return Road(octaves(rng, tile, _GRAINS, 4.0, strengths, 3.1), half_width, middle, light, shade)
