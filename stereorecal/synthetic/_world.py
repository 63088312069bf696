"""A world: patches, ground, sky, haze and the motion of the rig; and ray casting in it: radiance, haze included, and
depth along each ray.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._motion import RigMotion
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Patch
from stereorecal.synthetic._ray_patch_hits import Rays, trace
from stereorecal.synthetic._road import Road
from stereorecal.synthetic._sky import Sky
from stereorecal.synthetic._water import Water

_CHUNK = 1 << 16  # rays at a time: bounds the memory that the octaves of the ground take
_ROW = 256  # rays in a row of a chunk


@dataclass(frozen=True, eq=False)
class World:
    """Everything that a rendered scene shows.

    Attributes:
        patches: the solid objects.
        ground: the surface at y = 0.
        sky: the sky.
        haze: distance [m] over which haze reduces contrast to 1/e.
        motion: pose of the rig in each frame.
    """

    patches: tuple[Patch, ...]
    ground: Water | Road
    sky: Sky
    haze: float
    motion: RigMotion


def radiance(world: World, rays: Rays, time: float) -> Texture:
    """Radiance (h, w) float32 along each ray at `time` [s]: of the first patch that it hits, else of ground or sky; 0
    where there is none (NaN), as beyond the field of a lens."""
    dark = np.isnan(rays.directions[..., 0])
    if dark.any():
        somewhere = np.where(dark[..., None], np.array([0.0, 0.0, 1.0], np.float32), rays.directions)
        return np.where(dark, np.float32(0.0), radiance(world, replace(rays, directions=somewhere), time))
    hit_distance, colour = trace(world.patches, rays)
    lengths = np.sqrt(np.einsum("ijk,ijk->ij", rays.directions, rays.directions))
    solid = np.isfinite(hit_distance)
    colour = _hazy(world, colour, np.where(solid, hit_distance, 0.0) * lengths)
    flat_colour, flat_lengths = colour.reshape(-1), lengths.reshape(-1)
    flat_directions = rays.directions.reshape(-1, 3)
    falling = rays.directions[..., 1] < -1e-5
    for ground, where in ((True, falling & ~solid), (False, ~falling & ~solid)):
        chosen = np.flatnonzero(where)
        for start in range(0, chosen.size, _CHUNK):
            index = chosen[start : start + _CHUNK]
            # A rectangle, because OpenCV's remap takes no row this long; the last ray is repeated to fill it.
            index = np.pad(index, (0, -index.size % _ROW), mode="edge").reshape(-1, _ROW)
            direction = flat_directions[index] / flat_lengths[index][..., None]
            flat_colour[index] = _ground(world, rays, direction, time) if ground else world.sky.radiance(direction)
    return colour


def depth(world: World, rays: Rays) -> Texture:
    """Depth t (h, w) float32 of the first hit, patch or ground, at `centre + t direction`; infinite for the sky."""
    met, _ = trace(world.patches, rays)
    falling = np.minimum(rays.directions[..., 1], np.float32(-1e-9))
    return np.minimum(met, np.where(falling < -1e-7, np.float32(-rays.centre[1]) / falling, np.inf))


def _ground(world: World, rays: Rays, direction: Float[np.ndarray, "h w 3"], time: float) -> Texture:
    """Radiance of the ground along downward unit directions, haze included."""
    distance = np.float32(rays.centre[1]) / -direction[..., 1]
    x = np.float32(rays.centre[0]) + distance * direction[..., 0]
    z = np.float32(rays.centre[2]) + distance * direction[..., 2]
    light = world.ground.radiance(x, z, direction, distance, rays.spread, time, world.sky)
    return _hazy(world, light, distance)


def _hazy(world: World, light: Texture, distance: Texture) -> Texture:
    """Light after `distance` [m] of haze: exponential attenuation, with the radiance of the horizon scattered in."""
    clear = np.exp(distance * np.float32(-1.0 / world.haze))
    return light * clear + np.float32(world.sky.horizon) * (1.0 - clear)
