"""Render: a world through the two cameras of a rig, and what is true about it."""

import difflib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache

import cv2
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig, View, rectifying_rotations, view as make_view
from stereorecal.recordings import Pair, Scene
from stereorecal.synthetic._rig import default_rig
from stereorecal.synthetic.rendering._noise import Texture
from stereorecal.synthetic.rendering._sensor import expose
from stereorecal.synthetic.rendering._trace import Rays, trace
from stereorecal.synthetic.scenes._coast import coast
from stereorecal.synthetic.scenes._harbour import harbour
from stereorecal.synthetic.scenes._open_sea import open_sea
from stereorecal.synthetic.scenes._street import street
from stereorecal.synthetic.scenes._world import World

_MAKERS: dict[str, Callable[[np.random.Generator], World]] = {
    "harbour": harbour,
    "coast": coast,
    "open-sea": open_sea,
    "street": street,
}
KINDS = tuple(_MAKERS)

_SUPERSAMPLE = 2
_SECONDS_PER_FRAME = 0.2
_CHUNK = 1 << 16
_ROW = 256


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """What is true about the left image in a rectified view.

    Attributes:
        disparity: (h, w) float32 in pixels, for every pixel; the sky has the disparity of infinity.
        occluded: (h, w) bool, True where the right camera does not see what the left one sees.
    """

    disparity: Float[np.ndarray, "h w"]
    occluded: Bool[np.ndarray, "h w"]


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
    """A scene photographed through a rig that is known exactly; the same arguments give the same images.

    Args:
        kind: one of `KINDS`.
        seed: draws layout, light, textures and noise.
        rig: the cameras (default: `default_rig()`).
        frames: how many pairs; the rig moves on and the waves run from one to the next.
        noise: standard deviation of shot and read noise, in grey levels.
        exposure: the right camera is at most this fraction brighter or darker than the left one.
        vignetting: fraction of the light that is lost in the corners.
        blur: sigma of the lens blur in pixels.

    Raises:
        InputError: for an unknown kind, a negative seed, or less than one frame.
    """
    if frames < 1:
        raise InputError(f"frames is {frames}; render at least one frame.")
    rig, world = rig or default_rig(), _world(kind, seed)
    draw = np.random.default_rng([seed, 7])
    gains = 1.0, 1.0 + float(draw.uniform(-exposure, exposure))
    cameras = rig.left, rig.right
    centres = [_middle(camera) * (1.0 + draw.uniform(-0.04, 0.04, 2)) for camera in cameras]
    directions = [_rays(camera) for camera in cameras]

    def photograph(frame: int, side: int) -> Texture:
        rays = _world_rays(world, rig, frame, side, directions[side], cameras[side].matrix[0, 0])
        light = _radiance(world, rays, frame * _SECONDS_PER_FRAME)
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


def ground_truth(
    kind: str, seed: int, *, rig: StereoRig | None = None, view: View | None = None, frame: int = 0
) -> GroundTruth:
    """The disparity and the occlusions of the pair that `render(kind, seed, rig=rig)` takes as its `frame`.

    Args:
        view: the rectified cameras (default: the rig's own view).

    Raises:
        InputError: for an unknown kind or a negative seed.
    """
    rig, world = rig or default_rig(), _world(kind, seed)
    view = view or make_view(rig)
    left_turn, _ = rectifying_rotations(rig.rotation, rig.translation)
    pixels = _grid(view.size)
    ideal = np.concatenate([pixels, np.ones_like(pixels[..., :1])], -1) @ np.linalg.inv(view.matrix_left).T
    directions = ideal @ left_turn
    rays = _world_rays(world, rig, frame, 0, directions.astype(np.float32), view.focal)
    depth = _depth(world, rays)
    inverse = 1.0 / depth.astype(float)
    infinity = float(view.centre_left) - float(view.centre_right)
    disparity = float(view.focal) * float(rig.baseline) * inverse + infinity

    # Points at infinity are left out of the second look; they are seen wherever the right image reaches.
    near = np.isfinite(depth)
    points = directions * np.where(near, depth, 1e5)[..., None]
    in_right = points @ rig.rotation.T + rig.translation
    back = in_right / np.maximum(in_right[..., 2:], 1e-6)
    second = _world_rays(world, rig, frame, 1, back.astype(np.float32), view.focal)
    first_met = _depth(world, second)
    hidden = first_met < 0.995 * in_right[..., 2]
    return GroundTruth(disparity.astype(np.float32), hidden | ~_inside(rig.right, back, in_right[..., 2]))


@lru_cache(maxsize=4)
def _world(kind: str, seed: int) -> World:
    if kind not in _MAKERS:
        close = difflib.get_close_matches(str(kind), KINDS, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else "."
        raise InputError(f"unknown kind of scene {kind!r}: it must be one of {', '.join(KINDS)}{hint}")
    if seed < 0:
        raise InputError(f"the seed is {seed}; give a whole number that is not negative.")
    return _MAKERS[kind](np.random.default_rng([KINDS.index(kind), seed]))


def _radiance(world: World, rays: Rays, time: float) -> Texture:
    """What the rays see, (h, w) float32."""
    depth, radiance = trace(world.patches, rays)
    lengths = np.sqrt(np.einsum("ijk,ijk->ij", rays.directions, rays.directions))
    solid = np.isfinite(depth)
    distance = np.where(solid, depth, 0.0) * lengths
    radiance = _hazy(world, radiance, distance)
    flat_radiance, flat_lengths = radiance.reshape(-1), lengths.reshape(-1)
    flat_directions = rays.directions.reshape(-1, 3)
    falling = rays.directions[..., 1] < -1e-5
    for ground, where in ((True, falling & ~solid), (False, ~falling & ~solid)):
        chosen = np.flatnonzero(where)
        for start in range(0, chosen.size, _CHUNK):
            index = chosen[start : start + _CHUNK]
            # A rectangle, because OpenCV's remap takes no row this long; the last ray fills it up.
            index = np.pad(index, (0, -index.size % _ROW), mode="edge").reshape(-1, _ROW)
            length = flat_lengths[index]
            direction = flat_directions[index] / length[..., None]
            if not ground:
                flat_radiance[index] = world.sky.radiance(direction)
                continue
            distance = np.float32(rays.centre[1]) / -direction[..., 1]
            x = np.float32(rays.centre[0]) + distance * direction[..., 0]
            z = np.float32(rays.centre[2]) + distance * direction[..., 2]
            light = world.ground.radiance(x, z, direction, distance, rays.spread, time, world.sky)
            flat_radiance[index] = _hazy(world, light, distance)
    return radiance


def _hazy(world: World, radiance: Texture, distance: Texture) -> Texture:
    clear = np.exp(distance * np.float32(-1.0 / world.haze))
    return radiance * clear + np.float32(world.sky.horizon) * (1.0 - clear)


def _depth(world: World, rays: Rays) -> Texture:
    """Depth of what the rays meet, the ground included; infinite for the sky."""
    depth, _ = trace(world.patches, rays)
    falling = np.minimum(rays.directions[..., 1], np.float32(-1e-9))
    return np.minimum(depth, np.where(falling < -1e-7, np.float32(-rays.centre[1]) / falling, np.inf))


def _world_rays(world: World, rig: StereoRig, frame: int, side: int, directions, focal) -> Rays:
    """Rays of the left (0) or right (1) camera, turned into the world frame."""
    centre, to_world = world.pose(frame)
    spread = 1.0 / float(focal) / _SUPERSAMPLE
    if side == 1:
        centre = centre - to_world @ rig.rotation.T @ rig.translation
        to_world = to_world @ rig.rotation.T
    return Rays(centre, directions @ to_world.T.astype(np.float32), spread)


_camera_rays = jax.jit(lambda camera, pixels: camera.rays(pixels))


def _rays(camera: Camera) -> Float[np.ndarray, "h w 3"]:
    """Rays (x/z, y/z, 1) of 2 x 2 samples in each pixel, camera frame."""
    return _rays_of(camera.size, camera.matrix.tobytes(), camera.distortion.tobytes(), float(camera.lens_radius))


@lru_cache(maxsize=4)
def _rays_of(size: tuple[int, int], matrix: bytes, distortion: bytes, lens_radius: float):
    """`_rays` of a camera given by its numbers, so that scenes of equal cameras share them.

    The samples lie a quarter of a pixel off the centres, near enough to follow the slope of the exact rays.
    """
    camera = Camera(size, np.frombuffer(matrix).reshape(3, 3), np.frombuffer(distortion), lens_radius)
    centre = np.asarray(_camera_rays(camera, jnp.asarray(_grid(size), jnp.float32)))
    down, across = (np.float32(0.25) * slope for slope in np.gradient(centre, axis=(0, 1)))
    fine = np.empty((2 * size[1], 2 * size[0], 3), np.float32)
    for row, sign_y in enumerate((-1, 1)):
        for column, sign_x in enumerate((-1, 1)):
            fine[row::2, column::2] = centre + sign_y * down + sign_x * across
    fine.setflags(write=False)
    return fine


def _grid(size: tuple[int, int]) -> Float[np.ndarray, "h w 2"]:
    return np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1])), -1).astype(float)


def _middle(camera: Camera) -> Float[np.ndarray, "2"]:
    return 0.5 * (np.array(camera.size, float) - 1.0)


def _inside(camera: Camera, rays: Float[np.ndarray, "h w 3"], z: Float[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """Which rays (camera frame) fall into the image."""
    within = (z > 0) & (np.sum(rays[..., :2] ** 2, -1) < float(camera.lens_radius) ** 2)
    pixels = camera.project(np.where(within[..., None], rays, [0.0, 0.0, 1.0]))
    limit = np.array(camera.size) - 1.0
    return within & np.all((pixels >= 0.0) & (pixels <= limit), axis=-1)
