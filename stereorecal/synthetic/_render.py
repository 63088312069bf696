"""Rendering of a scene: the images that the two cameras of a rig take of a world."""

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.recordings import Pair, Scene
from stereorecal.synthetic._camera import expose, supersampled_rays, world_rays
from stereorecal.synthetic._default_rig import default_rig
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._scenes import make_world
from stereorecal.synthetic._world import radiance

_SECONDS_PER_FRAME = 0.2  # how far the waves run between frames; chosen


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
    centres = [_middle(camera) * (1.0 + draw.uniform(-0.04, 0.04, 2)) for camera in cameras]
    directions = [supersampled_rays(camera) for camera in cameras]
    focals = [float(camera.focal[0]) for camera in cameras]

    def photograph(frame: int, side: int) -> Texture:
        rays = world_rays(world.motion.pose(frame), rig, side, directions[side], focals[side])
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


def _middle(camera: Camera) -> Float[np.ndarray, "2"]:
    return 0.5 * (np.array(camera.size, float) - 1.0)
