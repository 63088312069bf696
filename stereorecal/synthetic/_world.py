"""A world: patches, ground, sky, haze and the motion of the rig; and ray casting in it: radiance, haze included, and
depth along each ray.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.synthetic._ground import Road, Water
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Patch, Point, Rays, trace
from stereorecal.synthetic._sky import Sky

Pose = tuple[Point, Float[np.ndarray, "3 3"]]
"""Centre (3,) [m] of the left camera in the world, and the matrix (3, 3) from its frame to the world's. The world's y
points up and the camera's down, so the matrix is a reflection (determinant -1)."""

Motion = Callable[[float], Pose]
"""How a rig moves: its pose at a time in frames since the start."""

_CHUNK = 1 << 16  # rays at a time: bounds the memory that the octaves of the ground take
_ROW = 256  # rays in a row of a chunk
_TURN = np.radians(9.0)  # of a vehicle, to either side


@dataclass(frozen=True, eq=False)
class World:
    """Everything that a rendered scene shows."""

    patches: tuple[Patch, ...]  # the solid objects
    ground: Water | Road  # the surface at y = 0
    sky: Sky
    haze: float  # distance [m] over which haze reduces contrast to 1/e
    eye: float  # height [m] of the left camera
    motion: Motion  # of the rig from frame to frame


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


def drawn_motion(rng: np.random.Generator, eye: float, oscillation: float, speed: float) -> Motion:
    """The motion of a rig that looks slightly down at rest; after 3 m it stands, so that it runs into nothing.

    Args:
        oscillation: amplitude of pitch and of roll [rad].
        speed: distance [m] travelled per frame at the start.
    """
    pitch, roll = rng.uniform(-0.05, 0.0), rng.uniform(-0.03, 0.03)

    def pose(frame: float) -> Pose:
        centre = np.array([0.1 * np.sin(0.5 * frame), eye, 3.0 * np.tanh(speed * frame / 3.0)])
        return centre, _to_world(
            pitch + oscillation * np.sin(1.7 * frame), 0.0, roll + oscillation * np.sin(1.1 * frame)
        )

    return pose


def drawn_course(rng: np.random.Generator, eye: float, speed: float, oscillation: float) -> Motion:
    """The motion of a vehicle that turns through one place; smooth in time, so that one shutter can be late.

    Args:
        speed: metres a frame.
        oscillation: amplitude of pitch and of roll [rad].
    """
    rates = np.array([rng.uniform(0.05, 0.12), rng.uniform(0.1, 0.25), rng.uniform(0.1, 0.25)])
    sizes, phases = np.array([_TURN, oscillation, oscillation]), rng.uniform(0.0, 2.0 * np.pi, 3)

    def pose(time: float) -> Pose:
        yaw, pitch, roll = sizes * np.sin(rates * time + phases)
        return np.array([0.1 * np.sin(0.05 * time), eye, speed * time]), _to_world(pitch, yaw, roll)

    return pose


def _to_world(pitch: float, yaw: float, roll: float) -> Float[np.ndarray, "3 3"]:
    (sp, sr, sy), (cp, cr, cy) = np.sin([pitch, roll, yaw]), np.cos([pitch, roll, yaw])
    turn = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    tilt = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]]) @ np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return np.diag([1.0, -1.0, 1.0]) @ turn @ tilt
