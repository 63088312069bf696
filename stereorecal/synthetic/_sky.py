"""The sky, a vertical gradient with soft clouds, and the light of a day."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._noise import Texture, periodic, tile_at, wrapped
from stereorecal.synthetic._patch import Point


@dataclass(frozen=True, eq=False)
class Sky:
    """Radiance of the sky."""

    horizon: float  # radiance at it
    zenith: float  # radiance overhead
    cover: float  # contrast of the clouds
    clouds: Texture  # (n + 1, n + 1) float32, `wrapped`, 0..1
    drift: Float[np.ndarray, "2"]  # offset of the clouds, in tiles

    def gradient(self, elevation: Texture) -> Texture:
        """Radiance of the cloudless sky at the given sine of elevation."""
        rise = np.sqrt(np.clip(elevation, 0.0, 1.0))
        return np.float32(self.horizon) + np.float32(self.zenith - self.horizon) * rise

    def radiance(self, directions: Float[np.ndarray, "h w 3"]) -> Texture:
        """Radiance in unit directions (h, w, 3), world frame."""
        x, y, z = (np.ascontiguousarray(directions[..., i]) for i in range(3))
        scale = np.float32(0.35) / (np.maximum(y, 0.0) + np.float32(0.15))
        u, v = x * scale + np.float32(self.drift[0]), z * scale * np.float32(0.5) + np.float32(self.drift[1])
        cloud = tile_at(self.clouds, u, v)
        fade = np.clip(y * np.float32(6.0), 0.0, 1.0)
        return self.gradient(y) + np.float32(self.cover) * fade * cloud


def make_sky(rng: np.random.Generator, horizon: float, zenith: float, cover: float) -> Sky:
    """Draw a sky with clouds from `rng`."""
    field = periodic(rng, 256, lambda kx, ky: 1.0 / (4.0 + kx**2 + ky**2) ** 0.85)
    soft = 1.0 / (1.0 + np.exp(-2.0 * (field - 0.2)))
    return Sky(horizon, zenith, cover, wrapped(soft), rng.uniform(0.0, 1.0, 2))


@dataclass(frozen=True, eq=False)
class Light:
    """Sunlight and skylight."""

    sun: Point  # unit vector towards the sun
    direct: float  # irradiance of the sun at normal incidence
    ambient: float  # irradiance of the sky: relative, on an albedo of 1 it gives a radiance of 1

    def on(self, normal: Point) -> float:
        """Irradiance of a surface with this unit normal (Lambert's cosine law; vertical surfaces get less skylight)."""
        return self.ambient * (0.7 + 0.3 * float(normal[1])) + self.direct * max(0.0, float(normal @ self.sun))


def daylight(rng: np.random.Generator) -> Light:
    """Draw the light of a day: the sun behind or beside the camera, 26 to 54 degrees high."""
    azimuth, height = rng.uniform(-2.2, 2.2), rng.uniform(0.45, 0.95)
    sun = np.array([np.cos(height) * np.sin(azimuth), np.sin(height), -np.cos(height) * np.cos(azimuth)])
    return Light(sun, rng.uniform(0.75, 1.2), rng.uniform(0.28, 0.42))
