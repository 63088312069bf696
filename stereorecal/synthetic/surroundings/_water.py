"""Water: a flat plane whose waves tilt the mirror, seen through Fresnel reflection of the sky."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic.rendering._noise import Texture, wave_slopes
from stereorecal.synthetic.surroundings._ground import Octaves, octaves, shade_at
from stereorecal.synthetic.surroundings._sky import Sky

_WAVES = 12.0


@dataclass(frozen=True, eq=False)
class Water:
    """Water at y = 0.

    Attributes:
        octaves: the slopes of the waves.
        heading: where the waves run [rad].
        body: radiance that comes out of the water itself.
        shade: where objects hide the sky that the water mirrors.
    """

    octaves: Octaves
    heading: float
    body: float
    shade: Texture

    def radiance(
        self, x: Texture, z: Texture, directions: Float[np.ndarray, "h w 3"], distance, spread, time, sky: Sky
    ) -> Texture:
        """Radiance at ground points x, z [m] seen along unit `directions`; `time` [s] moves the waves."""
        grazing = np.maximum(-directions[..., 1], np.float32(1e-4))
        footprint = np.float32(spread) * distance / grazing ** np.float32(0.7)
        heading = np.array([np.cos(self.heading), np.sin(self.heading)])
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
        mirror = np.float32(0.02) + np.float32(0.98) * (1.0 - np.minimum(cosine, 1.0)) ** 5
        # Waves that are too fine to be seen still lift the mean of what a grazing ray mirrors.
        lift = np.float32(0.12) * np.clip(footprint, 0.0, 1.0)
        push = np.float32(1.0) + np.float32(0.4) * slope_z
        shade = shade_at(self.shade, x + z * slope_x * np.float32(0.12), z * push)
        mirrored = sky.gradient(np.minimum(up + lift, 1.0)) * shade + (1.0 - shade) * np.float32(0.06)
        return mirror * mirrored + (1.0 - mirror) * np.float32(self.body)


def make_water(rng: np.random.Generator, roughness: float, longest: float, body: float, shade: Texture) -> Water:
    """Waves up to `longest` [m] long, with `roughness` the slope (rms) of an octave."""
    heading = float(rng.uniform(-np.pi, np.pi))
    tile = wave_slopes(rng, 256, _WAVES, heading)
    strengths = [roughness * s for s in (0.7, 0.8, 0.9, 1.0, 1.0, 0.9, 0.8)]
    return Water(octaves(rng, tile, _WAVES, longest, strengths, 0.7), heading, body, shade)
