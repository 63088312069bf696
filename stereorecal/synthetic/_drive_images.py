"""The images of a drive, rendered place by place and cached in the user's folder, in weather whose sizes are chosen to
look right.
"""

import hashlib
import os
import uuid
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import UInt8
from platformdirs import user_cache_path

from stereorecal.recordings import Pair
from stereorecal.synthetic._camera import expose, pixel_rays, world_rays
from stereorecal.synthetic._drive import Drive
from stereorecal.synthetic._motion import drawn_course
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Patch
from stereorecal.synthetic._scenes import make_world
from stereorecal.synthetic._studio import Studio
from stereorecal.synthetic._vehicles import boat, car
from stereorecal.synthetic._world import radiance

_NIGHT = 0.05  # of daylight
_NIGHT_NOISE = 6.0  # grey levels
_VEIL = 0.25  # of the light is that of the rain
_STREAKS = 120
_DROPS = 6  # on the glass, for as long as the rain lasts

Images = UInt8[np.ndarray, "n 2 h w"]

_SECONDS_PER_FRAME = 0.1
_MOVING = (0.05, 0.2)  # metres a frame
_SPEED = {"harbour": 0.05, "coast": 0.05, "open-sea": 0.1, "street": 0.12}  # of the rig, likewise
_SWAY_ON_LAND, _SWAY_AFLOAT = 0.004, 0.012  # of pitch and roll [rad]
_BLUR, _VIGNETTING, _EXPOSURE = 0.7, 0.3, 0.15


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


def photographs(drive: Drive, first: int = 0, *, folder: str | os.PathLike[str] | None = None) -> Iterator[Pair]:
    """The pairs of a drive, from frame `first` on. They are rendered when they are first needed, place by place, a
    quarter of a second each, and cached.

    Args:
        folder: of the cache (15 MB for 100 frames); default: in the user's cache.
    """
    cache_folder = user_cache_path("stereorecal") / "drives" if folder is None else Path(folder)
    place, images = -1, None
    for frame in range(first, len(drive)):
        if images is None or drive.place(frame) != place:
            place = drive.place(frame)
            images = _cached(drive, place, cache_folder)
        left, right = images[frame - drive.frames_at(place)[0]].astype(np.float32)
        yield Pair(left, right, f"{drive.tour}-{drive.seed}-{frame:05d}")


def _cached(drive: Drive, place: int, folder: Path) -> Images:
    """The images at a place, left and right, from the cache or rendered."""
    frames = drive.frames_at(place)
    key = [drive.tour, drive.seed, place, drive.moving, drive.weather[frames[0]], _sources()]
    numbers = drive.extrinsics[frames[0] : frames[-1] + 1].tobytes() + drive.late[frames[0] : frames[-1] + 1].tobytes()
    name = hashlib.sha256(repr(key).encode() + numbers).hexdigest()[:24]
    path = folder / f"{drive.tour}-{name}.npy"
    with suppress(OSError, ValueError):  # missing, or truncated
        return np.load(path)
    images = _rendered(drive, place)
    with suppress(OSError):  # a full disk: not cached
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_name(f".{path.stem}.{uuid.uuid4().hex[:8]}.npy")
        np.save(part, images)
        os.replace(part, path)
    return images


@cache
def _sources() -> str:
    """A digest of the code that makes the images."""
    files = sorted(Path(__file__).parent.rglob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def _rendered(drive: Drive, place: int) -> Images:
    kind, frames, weather = drive.kind(place), drive.frames_at(place), drive.weather[place * len(drive.frames_at(0))]
    world = make_world(kind, 1000 * drive.seed + place)
    draw = np.random.default_rng([drive.seed, place, 29])
    course = drawn_course(draw, world.motion.eye, _SPEED[kind], _SWAY_ON_LAND if kind == "street" else _SWAY_AFLOAT)
    moving = _moving(kind, draw, world.motion.eye) if drive.moving else ()
    cameras = drive.rig.left, drive.rig.right
    directions = [pixel_rays(camera) for camera in cameras]
    gains = 1.0, 1.0 + float(np.random.default_rng([drive.seed, 7]).uniform(-_EXPOSURE, _EXPOSURE))
    images = np.empty((len(frames), 2, *directions[0].shape[:2]), np.uint8)
    for number, frame in enumerate(frames):
        rig = drive.truth(frame)
        for side in (0, 1):
            time = number + (drive.late[frame] if side else 0.0)
            shown = replace(world, patches=(*world.patches, *(patch.moved(time * way) for patch, way in moving)))
            focal = float(cameras[side].focal[0])
            rays = world_rays(course.pose(time), rig, side, directions[side], focal, samples=1)
            falling = np.random.default_rng([drive.seed, frame, side, 1])
            light = radiance(shown, rays, time * _SECONDS_PER_FRAME)
            light = lit(light, weather, falling, np.random.default_rng([drive.seed, side, 2]))
            middle = 0.5 * (np.array(cameras[side].size, float) - 1.0)
            how = {"gain": gains[side], "centre": middle, "noise": noise_of(weather)}
            images[number, side] = expose(light, falling, blur=_BLUR, vignetting=_VIGNETTING, **how)
    return images


def _moving(kind: str, draw: np.random.Generator, eye: float) -> tuple[tuple[Patch, np.ndarray], ...]:
    """The patches of a boat or a car, each with its way in a frame, (3,) metres."""
    studio, sign = Studio(draw, eye), float(draw.choice([-1.0, 1.0]))
    speed, far = sign * draw.uniform(*_MOVING), draw.uniform(8.0, 14.0)
    if kind == "street":
        car(studio, (sign * -0.8, far), (0.0, sign))
        way = np.array([0.0, 0.0, speed])
    else:
        boat(studio, (-sign * 0.4 * far, far), draw.uniform(4.0, 6.0), 0.0, mast=True)
        way = np.array([speed, 0.0, 0.0])
    return tuple((patch, way) for patch in studio.patches)
