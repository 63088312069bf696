"""Trees."""

import numpy as np

from stereorecal.synthetic.objects._nature import crown
from stereorecal.synthetic.objects._things import Things
from stereorecal.synthetic.rendering._studio import Studio
from stereorecal.synthetic.surroundings._ground import Stain


def tree(studio: Studio, foot: tuple[float, float], tall: float) -> Things:
    """A tree `tall` [m] at ground point `foot`: a trunk, clumps of leaves around it, and its shadow."""
    rng = studio.rng
    patches = [studio.pole(foot, 0.28, 0.0, 0.55 * tall, 0.1)]
    for _ in range(7):
        away, angle = rng.uniform(0.1, 0.26) * tall, rng.uniform(0.0, 2 * np.pi)
        spot = (foot[0] + away * np.cos(angle), foot[1] + away * np.sin(angle))
        width, low = float(rng.uniform(0.32, 0.5)) * tall, float(rng.uniform(0.36, 0.68)) * tall
        patches.append(studio.card(spot, width, low, low + 0.85 * width, crown(float(rng.uniform(0.08, 0.16)))))
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    shift = studio.light.sun[[0, 2]] * (-0.6 * tall / studio.light.sun[1])
    circle = np.array(foot) + shift + 0.3 * tall * np.stack([np.cos(angles), np.sin(angles)], -1)
    return patches, [Stain(circle, 0.6)]
