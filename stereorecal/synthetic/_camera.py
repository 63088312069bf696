"""A camera: rays through its pixels, in its frame and in the world's; and from radiance to grey levels: lens blur,
vignetting, tone curve, exposure, noise, quantisation.
"""

from functools import lru_cache

import cv2
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal.geometry import Camera, StereoRig
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Point
from stereorecal.synthetic._ray_patch_hits import Rays

_SUPERSAMPLE = 2  # per axis: 4 samples a pixel antialias the edges of patches

_camera_rays = jax.jit(lambda camera, pixels: (camera.directions if camera.lens.WIDE else camera.rays)(pixels))


def supersampled_rays(camera: Camera) -> Float[np.ndarray, "h w 3"]:
    """Rays of 2 x 2 samples in each pixel, (2h, 2w, 3) float32 for an image of h x w, camera frame: (x/z, y/z, 1), or
    unit vectors of a wide lens."""
    return _rays_of(camera.size, camera.matrix.tobytes(), camera.distortion.tobytes(), camera.model)


def pixel_rays(camera: Camera) -> Float[np.ndarray, "h w 3"]:
    """The same through the centres of the pixels, (h, w, 3)."""
    return np.asarray(_camera_rays(camera, jnp.asarray(pixel_grid(camera.size), jnp.float32)))


@lru_cache(maxsize=4)
def _rays_of(size: tuple[int, int], matrix: bytes, distortion: bytes, model: str):
    """`supersampled_rays` of a camera given by its numbers, so that scenes of equal cameras share them.

    The samples lie a quarter of a pixel off the pixel centres, near enough for a first-order expansion of the rays.
    """
    camera = Camera(size, np.frombuffer(matrix).reshape(3, 3), np.frombuffer(distortion), model=model)
    centre = np.asarray(_camera_rays(camera, jnp.asarray(pixel_grid(size), jnp.float32)))
    down, across = (np.float32(0.25) * slope for slope in np.gradient(centre, axis=(0, 1)))
    fine = np.empty((2 * size[1], 2 * size[0], 3), np.float32)
    for row, sign_y in enumerate((-1, 1)):
        for column, sign_x in enumerate((-1, 1)):
            fine[row::2, column::2] = centre + sign_y * down + sign_x * across
    fine.setflags(write=False)
    return fine


def world_rays(
    pose: tuple[Point, Float[np.ndarray, "3 3"]],
    rig: StereoRig,
    side: int,
    directions: Float[np.ndarray, "h w 3"],
    focal: float,
    samples: int = _SUPERSAMPLE,
) -> Rays:
    """Rays of one camera of a rig in the world frame.

    Args:
        pose: centre (3,) [m] of the left camera, and the matrix from its frame to the world's.
        side: 0 for the left camera, 1 for the right one.
        directions: (h, w, 3) float32, in the frame of that camera.
        focal: focal length [px] of the image, for the choice of texture detail.
        samples: of a pixel, per axis.
    """
    centre, to_world = pose
    spread = 1.0 / focal / samples
    if side == 1:
        centre = centre - to_world @ rig.rotation.T @ rig.translation
        to_world = to_world @ rig.rotation.T
    return Rays(centre, directions @ to_world.T.astype(np.float32), spread)


def pixel_grid(size: tuple[int, int]) -> Float[np.ndarray, "h w 2"]:
    """Pixel coordinates (column, row) of an image of `size` (width, height)."""
    return np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1])), -1).astype(float)


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
