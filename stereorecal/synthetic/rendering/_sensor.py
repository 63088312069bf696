"""Camera model from radiance to grey levels: lens blur, vignetting, tone curve, exposure, noise, quantisation."""

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.synthetic.rendering._noise import Texture


def expose(
    radiance: Texture,
    noise_rng: np.random.Generator,
    *,
    gain: float,
    centre: Float[np.ndarray, "2"],
    blur: float,
    vignetting: float,
    noise: float,
) -> Texture:
    """The image (h, w) float32, whole grey levels in 0..255.

    Args:
        radiance: (h, w) float32, relative; a bright sky has about 1.
        gain: factor on the grey levels.
        centre: (2,) centre (x, y) of the vignetting in pixels; no light is lost there.
        blur: sigma of the lens blur in pixels.
        vignetting: fraction of the light lost in the corners, 0..1.
        noise: standard deviation in grey levels at mid-grey; half of its variance is shot noise.
    """
    height, width = radiance.shape
    if blur > 0.0:
        radiance = cv2.GaussianBlur(radiance, (0, 0), blur, borderType=cv2.BORDER_REPLICATE)
    x, y = np.arange(width) - centre[0], np.arange(height) - centre[1]
    falloff = 1.0 - vignetting * (x[None, :] ** 2 + y[:, None] ** 2) / (0.25 * (width**2 + height**2))
    grey = 255.0 * gain * tone(radiance * falloff.astype(np.float32))
    sigma = noise * np.sqrt(0.5 + 0.5 * np.clip(grey, 0.0, 255.0) / 128.0)
    noisy = grey + sigma * noise_rng.standard_normal(grey.shape, dtype=np.float32)
    return np.rint(np.clip(noisy, 0.0, 255.0)).astype(np.float32)


def tone(radiance: Texture) -> Texture:
    """Tone curve from radiance to grey (1 is white): a shoulder that compresses highlights, gamma, a mild S-curve."""
    # Reinhard's operator with white at a light of sqrt(3), gamma 2; the factors are chosen by eye.
    light = np.maximum(radiance, 0.0) * np.float32(1.15)
    grey = np.minimum(light * (1.0 + light / 3.0) / (1.0 + light), 1.0) ** np.float32(1.0 / 2.0)
    curved = grey * grey * (3.0 - 2.0 * grey)
    return grey + np.float32(0.7) * (curved - grey)
