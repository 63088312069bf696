"""Daylight: direction and irradiance of the sun, and irradiance of the sky."""

import numpy as np

from stereorecal.synthetic.rendering._patch import Light


def daylight(rng: np.random.Generator) -> Light:
    """Draw the light of a day: the sun behind or beside the camera, 26 to 54 degrees high."""
    azimuth, height = rng.uniform(-2.2, 2.2), rng.uniform(0.45, 0.95)
    sun = np.array([np.cos(height) * np.sin(azimuth), np.sin(height), -np.cos(height) * np.cos(azimuth)])
    return Light(sun, float(rng.uniform(0.75, 1.2)), float(rng.uniform(0.28, 0.42)))
