"""Rendering of a scene: the images that the two cameras of a rig, known exactly, take of a world. Rays through their
pixels; then from radiance to grey levels: lens blur, vignetting, tone curve, exposure, noise, quantisation. And random
drift of a rig, as vibration, temperature or a knock would cause.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import cv2
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.recordings import Pair, Scene
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Rays
from stereorecal.synthetic._scenes import make_world
from stereorecal.synthetic._world import Pose, radiance

_SECONDS_PER_FRAME = 0.2  # how far the waves run between frames; chosen

_camera_rays = jax.jit(lambda camera, pixels: (camera.directions if camera.lens.WIDE else camera.rays)(pixels))


def default_rig() -> StereoRig:
    """A 640x480 rig with a baseline of about 356 mm, radial distortion, and extrinsics that are not ideal.

    The cameras differ slightly from each other, and the extrinsics are a few tenths of a degree and a few millimetres
    off the ideal rig, so that a bias of a strategy towards the ideal rig shows as an error. All numbers are invented; a
    camera sees about 56 degrees across.
    """
    left = Camera(
        (640, 480),
        np.array([[601.3, 0.0, 322.4], [0.0, 600.7, 236.8], [0.0, 0.0, 1.0]]),
        np.array([-0.251, 0.092, 0.0004, -0.0003, -0.012]),
    )
    right = Camera(
        (640, 480),
        np.array([[598.6, 0.0, 316.1], [0.0, 598.9, 243.5], [0.0, 0.0, 1.0]]),
        np.array([-0.246, 0.085, -0.0002, 0.0005, -0.009]),
    )
    angles = np.radians([0.31, -0.44, 0.27])
    return StereoRig(left, right, np.concatenate([angles, [-0.356, 0.0041, -0.0036]]))


def decalibrate(rig: StereoRig, key: jax.Array, degrees: float, baseline_fraction: float) -> StereoRig:
    """The rig with a random drift added to its extrinsics, float64.

    Pitch, yaw, roll, y and z drift independently, each uniformly within its limit to either side; x does not drift.

    Args:
        key: a `jax.random.key`.
        degrees: largest drift of each angle, in degrees.
        baseline_fraction: largest drift of y and of z, as a fraction of the rig's baseline.

    Raises:
        InputError: if a limit is negative or not finite.
    """
    for name, limit in (("degrees", degrees), ("baseline_fraction", baseline_fraction)):
        if not (np.isfinite(limit) and limit >= 0.0):
            raise InputError(f"{name} is {limit}; give a drift limit that is finite and not negative.")
    shift = baseline_fraction * rig.baseline
    limits = np.array([*[np.radians(degrees)] * 3, 0.0, shift, shift])
    draw = np.asarray(jax.random.uniform(key, (6,), minval=-1.0, maxval=1.0), np.float64)
    return rig.with_extrinsics(np.asarray(rig.extrinsics, np.float64) + limits * draw)


def render(
    kind: str,
    seed: int,
    *,
    rig: StereoRig | None = None,
    frames: int = 1,
    noise: float = 2.0,
    exposure: float = 0.15,
    vignetting: float = 0.3,
    blur: float = 0.7,
) -> Scene:
    """Render a scene through a rig that is known exactly; the same arguments give the same images.

    Args:
        kind: one of `KINDS`.
        seed: of layout, light, textures and noise; not negative.
        rig: the cameras (default: `default_rig()`).
        frames: number of pairs; the rig moves, and so do the waves, from one to the next.
        noise: standard deviation of shot and read noise together at mid-grey, in grey levels.
        exposure: largest relative difference in brightness of the right camera from the left one; drawn uniformly.
        vignetting: fraction of the light that is lost in the corners, 0..1.
        blur: sigma of the lens blur in pixels.

    Raises:
        InputError: for an unknown kind, a negative seed, or fewer than one frame.
    """
    if frames < 1:
        raise InputError(f"frames is {frames}; render at least one frame.")
    rig, world = rig or default_rig(), make_world(kind, seed)
    draw = np.random.default_rng([seed, 7])
    gains = 1.0, 1.0 + float(draw.uniform(-exposure, exposure))
    cameras = rig.left, rig.right
    # The optical axis of a real lens misses the middle of the sensor by a few percent.
    centres = [camera.middle * (1.0 + draw.uniform(-0.04, 0.04, 2)) for camera in cameras]
    directions = [_supersampled_rays(c.size, c.matrix.tobytes(), c.distortion.tobytes(), c.model) for c in cameras]
    spreads = [0.5 / float(camera.focal[0]) for camera in cameras]

    def photograph(frame: int, side: int) -> Texture:
        rays = world_rays(world.motion(frame), rig, side, directions[side], spreads[side])
        light = radiance(world, rays, frame * _SECONDS_PER_FRAME)
        light = cv2.resize(light, cameras[side].size, interpolation=cv2.INTER_AREA)
        grain = np.random.default_rng([seed, frame, side])
        gain, centre = gains[side], centres[side]
        return expose(light, grain, gain=gain, centre=centre, blur=blur, vignetting=vignetting, noise=noise)

    with ThreadPoolExecutor(2) as pool:
        jobs = [[pool.submit(photograph, frame, side) for side in (0, 1)] for frame in range(frames)]
        pairs = [
            Pair(left.result(), right.result(), f"{kind}-{seed}-{frame:03d}")
            for frame, (left, right) in enumerate(jobs)
        ]
    return Scene(f"{kind}-{seed}", rig, tuple(pairs), "truth", {"kind": kind, "seed": seed})


def pixel_rays(camera: Camera) -> Float[np.ndarray, "h w 3"]:
    """Rays through the centres of the pixels, (h, w, 3) float32, camera frame: (x/z, y/z, 1), or unit vectors of a wide
    lens."""
    return np.asarray(_camera_rays(camera, jnp.asarray(pixel_grid(camera.size), jnp.float32)))


@lru_cache(maxsize=4)
def _supersampled_rays(size: tuple[int, int], matrix: bytes, distortion: bytes, model: str):
    """Rays of 2 x 2 samples in each pixel, which antialias edges, (2h, 2w, 3) float32, camera frame: (x/z, y/z, 1), or
    unit vectors of a wide lens. The camera is given by its numbers, so that scenes of equal cameras share them; the
    samples lie a quarter of a pixel off the pixel centres, near enough for a first-order expansion."""
    camera = Camera(size, np.frombuffer(matrix).reshape(3, 3), np.frombuffer(distortion), model=model)
    centre = pixel_rays(camera)
    down, across = (np.float32(0.25) * slope for slope in np.gradient(centre, axis=(0, 1)))
    fine = np.empty((2 * size[1], 2 * size[0], 3), np.float32)
    for row, sign_y in enumerate((-1, 1)):
        for column, sign_x in enumerate((-1, 1)):
            fine[row::2, column::2] = centre + sign_y * down + sign_x * across
    fine.setflags(write=False)
    return fine


def world_rays(pose: Pose, rig: StereoRig, side: int, directions: Float[np.ndarray, "h w 3"], spread: float) -> Rays:
    """Rays of one camera of a rig in the world frame.

    Args:
        side: 0 for the left camera, 1 for the right one.
        directions: (h, w, 3) float32, in the frame of that camera.
        spread: angle between neighbours, for the choice of texture detail.
    """
    centre, to_world = pose
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
    grey = 255.0 * gain * _tone(radiance * falloff.astype(np.float32))
    sigma = noise * np.sqrt(0.5 + 0.5 * np.clip(grey, 0.0, 255.0) / 128.0)
    noisy = grey + sigma * noise_rng.standard_normal(grey.shape, dtype=np.float32)
    return np.rint(np.clip(noisy, 0.0, 255.0)).astype(np.float32)


def _tone(radiance: Texture) -> Texture:
    """Tone curve from radiance to grey (1 is white): a shoulder that compresses highlights, gamma, a mild S-curve."""
    # Reinhard's operator with white at a light of sqrt(3), gamma 2; the factors are chosen by eye.
    light = np.maximum(radiance, 0.0) * np.float32(1.15)
    grey = np.minimum(light * (1.0 + light / 3.0) / (1.0 + light), 1.0) ** np.float32(1.0 / 2.0)
    curved = grey * grey * (3.0 - 2.0 * grey)
    return grey + np.float32(0.7) * (curved - grey)
