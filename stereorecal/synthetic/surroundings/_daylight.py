"""Daylight: direction and irradiance of the sun, and irradiance of the sky."""

from dataclasses import dataclass

import numpy as np

from stereorecal.synthetic.rendering._patch import Point


@dataclass(frozen=True, eq=False)
class Light:
    """Sunlight and skylight.

    Attributes:
        sun: (3,) unit vector towards the sun.
        direct, ambient: irradiance of the sun at normal incidence and of the sky, relative: an albedo of 1 under an
            irradiance of 1 gives a radiance of 1.
    """

    sun: Point
    direct: float
    ambient: float

    def on(self, normal: Point) -> float:
        """Irradiance of a surface with this unit normal (Lambert's cosine law; vertical surfaces get less skylight)."""
        return self.ambient * (0.7 + 0.3 * float(normal[1])) + self.direct * max(0.0, float(normal @ self.sun))


def daylight(rng: np.random.Generator) -> Light:
    """Draw the light of a day: the sun behind or beside the camera, 26 to 54 degrees high."""
    azimuth, height = rng.uniform(-2.2, 2.2), rng.uniform(0.45, 0.95)
    sun = np.array([np.cos(height) * np.sin(azimuth), np.sin(height), -np.cos(height) * np.cos(azimuth)])
    return Light(sun, rng.uniform(0.75, 1.2), rng.uniform(0.28, 0.42))
