"""Weather: its effect on the light that reaches a camera; sizes are chosen to look right."""

import cv2
import numpy as np

from stereorecal.synthetic.rendering._noise import Texture

_NIGHT = 0.05  # of daylight
_NIGHT_NOISE = 6.0  # grey levels
_VEIL = 0.25  # of the light is that of the rain
_STREAKS = 120
_DROPS = 6  # on the glass, for as long as the rain lasts


def noise_of(weather: str) -> float:
    """Standard deviation of a sensor's noise, grey levels."""
    return _NIGHT_NOISE if weather == "night" else 2.0


def lit(light: Texture, weather: str, falling: np.random.Generator, glass: np.random.Generator) -> Texture:
    """The light as it reaches one camera.

    Args:
        falling: draws what differs from frame to frame and from camera to camera: streaks.
        glass: draws what stays on this camera's glass: drops.
    """
    if weather == "night":
        return np.asarray(light * np.float32(_NIGHT))
    return _rained(light, falling, glass) if weather == "rain" else light


def _rained(light: Texture, falling: np.random.Generator, glass: np.random.Generator) -> Texture:
    height, width = light.shape
    grey = np.float32(light.mean())
    wet = light * np.float32(1.0 - _VEIL) + grey * np.float32(_VEIL)
    streaks = np.zeros_like(wet)
    for x, y, long, bright in falling.uniform((0, -20, 8, 0.1), (width, height, 24, 0.35), (_STREAKS, 4)):
        cv2.line(streaks, (int(x), int(y)), (int(x + 0.1 * long), int(y + long)), float(bright), 1, cv2.LINE_AA)
    wet = wet + np.float32(0.5) * grey * cv2.GaussianBlur(streaks, (0, 0), 0.8)
    blurred = cv2.GaussianBlur(wet, (0, 0), 6.0)
    cover = np.zeros_like(wet)
    for x, y, size in glass.uniform((0, 0, 5), (width, height, 14), (_DROPS, 3)):
        cv2.circle(cover, (int(x), int(y)), int(size), 1.0, -1, cv2.LINE_AA)
    cover = cv2.GaussianBlur(cover, (0, 0), 2.0)
    return wet + cover * (blurred - wet)
