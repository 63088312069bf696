"""Road: asphalt with markings, between two pavements. Albedos and widths are chosen by eye."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._ground import Octaves, octaves, shade_at
from stereorecal.synthetic._noise import Texture, periodic
from stereorecal.synthetic._sky import Sky

_GRAINS = 24.0  # grains across a tile of the texture


@dataclass(frozen=True, eq=False)
class Road:
    """A straight road along z at y = 0.

    Attributes:
        octaves: grain of asphalt and pavement.
        half_width: distance [m] from the centre line to the kerb.
        middle: x of the centre line [m].
        light: irradiance of the road.
        shade: map of the shadows (`shade_map`).
    """

    octaves: Octaves
    half_width: float
    middle: float
    light: float
    shade: Texture

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
