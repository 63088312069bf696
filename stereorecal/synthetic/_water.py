"""Water: a plane with wave normals and Fresnel reflection of the sky. Other constants are chosen to look right."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._ground import Octaves, octaves, shade_at
from stereorecal.synthetic._noise import Texture, wave_slopes
from stereorecal.synthetic._sky import Sky

_WAVES = 12.0  # wavelengths across a tile of the texture


@dataclass(frozen=True, eq=False)
class Water:
    """Water at y = 0.

    Attributes:
        octaves: slopes of the waves.
        heading: direction [rad] in which the waves travel.
        body: radiance of the water itself, without reflection.
        shade: map of the reflections of objects, which hide the sky (`shade_map`).
    """

    octaves: Octaves
    heading: float
    body: float
    shade: Texture

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
