"""A simulated drive: a moving rig that drifts, warms up and is knocked, in changing weather, with the true rig of each
frame; and its images, rendered place by place and cached in the user's folder. What sizes the weather has is chosen to
look right.
"""

import hashlib
import os
import uuid
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import groupby
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float, UInt8
from platformdirs import user_cache_path

from stereorecal import InputError
from stereorecal.geometry import StereoRig, rig_as_data
from stereorecal.recordings import Pair
from stereorecal.synthetic._noise import Texture
from stereorecal.synthetic._patch import Patch
from stereorecal.synthetic._render import default_rig, expose, pixel_rays, world_rays
from stereorecal.synthetic._scenes import make_world
from stereorecal.synthetic._studio import Studio
from stereorecal.synthetic._vehicles import boat, car
from stereorecal.synthetic._world import drawn_course, radiance

TOURS = {"harbour": ("harbour", "coast"), "street": ("street",)}
"""Name of each tour and the kinds of scenes that it passes through."""

SIZE = (320, 240)
"""The size of the images; the focal length is about 300 pixels."""

_PLACE = 50  # frames at one place: the rig travels a few metres there
_WALK = np.radians(1e-4)  # random walk of each angle, a frame
_WALK_SHIFT = 1e-6  # of y and z, likewise, in baselines
_HEAT = np.radians([0.1, 0.4, 0.1])  # over _WARM frames
_WARM = 500
_WEATHERS = ("clear", "rain", "clear", "night", "clear", "sea")  # of some places in turn
_STRETCH = 2  # places that share one weather
_NIGHT = 0.05  # of daylight
_NOISE, _NIGHT_NOISE = 2.0, 6.0  # standard deviation of a sensor's noise, grey levels
_VEIL = 0.25  # of the light is that of the rain
_STREAKS = 120
_DROPS = 6  # on the glass, for as long as the rain lasts

_Images = UInt8[np.ndarray, "n 2 h w"]

_SECONDS_PER_FRAME = 0.1
_MOVING = (0.05, 0.2)  # metres a frame
_SPEED = {"harbour": 0.05, "coast": 0.05, "open-sea": 0.1, "street": 0.12}  # of the rig, likewise
_SWAY_ON_LAND, _SWAY_AFLOAT = 0.004, 0.012  # of pitch and roll [rad]
_BLUR, _VIGNETTING, _EXPOSURE = 0.7, 0.3, 0.15


@dataclass(frozen=True)
class Knock:
    """A sudden turn of the right camera.

    Attributes:
        frame: the first that shows it.
        degrees: pitch, yaw, roll.
    """

    frame: int
    degrees: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Drive:
    """What happens on a drive; `photographs` takes its images.

    Attributes:
        tour: one of TOURS.
        seed: of places, weather and drift.
        rig: the calibration at the start, and the cameras.
        extrinsics: (n, 6) the true ones of each frame.
        weather: of each frame: "clear", "rain", "night" or "sea", open to the horizon.
        late: (n,) by how many frames the right shutter is late.
        knocks: what shook the rig.
        moving: whether things move across the view.
    """

    tour: str
    seed: int
    rig: StereoRig
    extrinsics: Float[np.ndarray, "n 6"] = field(repr=False)
    weather: tuple[str, ...] = field(repr=False)
    late: Float[np.ndarray, "n"] = field(repr=False)
    knocks: tuple[Knock, ...]
    moving: bool

    def __len__(self) -> int:
        return len(self.extrinsics)

    def truth(self, frame: int) -> StereoRig:
        """The rig as it was when a frame was taken."""
        return self.rig.with_extrinsics(self.extrinsics[frame])

    def place(self, frame: int) -> int:
        """The place at which a frame was taken; places are visited one after the other."""
        return frame // _PLACE

    def frames_at(self, place: int) -> range:
        """The frames that were taken at a place."""
        return range(place * _PLACE, min((place + 1) * _PLACE, len(self)))

    def kind(self, place: int) -> str:
        """The kind of scene at a place."""
        if self.weather[place * _PLACE] == "sea":
            return "open-sea"
        kinds = TOURS[self.tour]
        return kinds[place % len(kinds)]


def plan_drive(
    tour: str = "harbour",
    seed: int = 0,
    frames: int = 1000,
    *,
    heat: bool = False,
    knocks: tuple[Knock, ...] = (),
    late: tuple[tuple[int, int, float], ...] = (),
    weather: bool = True,
    moving: bool = True,
) -> Drive:
    """Plan a drive. The right camera always wanders by 1e-4 degrees a frame.

    Args:
        tour: "harbour" (harbours, coasts, open sea) or "street".
        seed: of places, weather and drift; not negative.
        frames: how many pairs are taken.
        heat: ramps of 0.1 degrees in pitch and roll and of 0.4 degrees in yaw over 500 frames, then back.
        knocks: sudden turns.
        late: (first, end, delay): frames in which the right shutter is late, by `delay` of a frame.
        weather: rain, night and open sea in turn; else it is always clear.
        moving: things move across the view.

    Raises:
        InputError: for an unknown tour, a negative seed, or no frame.
    """
    if tour not in TOURS or seed < 0 or frames < 1:
        raise InputError(f"a drive ({tour!r}, {seed}, {frames}): give one of {', '.join(TOURS)}, a seed, some frames.")
    draw, rig = np.random.default_rng([seed, 23]), default_rig().resized(SIZE)
    baseline = float(rig.baseline)
    steps = draw.standard_normal((frames, 6)) * np.array([_WALK] * 3 + [0.0] + [_WALK_SHIFT * baseline] * 2)
    steps[0] = 0.0
    drift = np.cumsum(steps, axis=0)
    if heat:
        warm = 1.0 - np.abs(1.0 - np.arange(frames) / _WARM % 2.0)  # up and down again
        drift[:, :3] += warm[:, None] * (_HEAT * draw.choice([-1.0, 1.0], 3))
    for knock in knocks:
        drift[knock.frame :, :3] += np.radians(knock.degrees)
    delay = np.zeros(frames)
    for first, end, size in late:
        delay[first:end] = size
    return Drive(
        tour=tour,
        seed=seed,
        rig=rig,
        extrinsics=np.asarray(rig.extrinsics) + drift,
        weather=_weather(tour, frames, int(draw.integers(len(_WEATHERS))) if weather else None),
        late=delay,
        knocks=knocks,
        moving=moving,
    )


def _weather(tour: str, frames: int, first: int | None) -> tuple[str, ...]:
    """The weather of each frame; the first stretch is always clear."""
    found = []
    for frame in range(frames):
        stretch = frame // (_PLACE * _STRETCH)
        now = "clear" if first is None or stretch == 0 else _WEATHERS[(first + stretch) % len(_WEATHERS)]
        found.append("clear" if now == "sea" and tour != "harbour" else now)
    return tuple(found)


def photographs(drive: Drive, first: int = 0, *, folder: str | os.PathLike[str] | None = None) -> Iterator[Pair]:
    """The pairs of a drive, from frame `first` on. They are rendered when they are first needed, place by place, a
    quarter of a second each, and cached.

    Args:
        folder: of the cache (15 MB for 100 frames); default: in the user's cache.
    """
    cache_folder = user_cache_path("stereorecal") / "drives" if folder is None else Path(folder)
    for place, frames in groupby(range(first, len(drive)), drive.place):
        images = _cached(drive, place, cache_folder)
        for frame in frames:
            left, right = images[frame - drive.frames_at(place)[0]].astype(np.float32)
            yield Pair(left, right, f"{drive.tour}-{drive.seed}-{frame:05d}")


def _cached(drive: Drive, place: int, folder: Path) -> _Images:
    """The images at a place, left and right, from the cache or rendered."""
    frames = drive.frames_at(place)
    cameras = rig_as_data(drive.rig)
    key = [drive.tour, drive.seed, place, drive.moving, drive.weather[frames[0]], cameras, _sources()]
    numbers = drive.extrinsics[frames[0] : frames[-1] + 1].tobytes() + drive.late[frames[0] : frames[-1] + 1].tobytes()
    name = hashlib.sha256(repr(key).encode() + numbers).hexdigest()[:24]
    path = folder / f"{drive.tour}-{name}.npy"
    with suppress(OSError, ValueError, EOFError):  # missing, truncated, or empty
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


def _rendered(drive: Drive, place: int) -> _Images:
    kind, frames = drive.kind(place), drive.frames_at(place)
    weather = drive.weather[frames[0]]
    world = make_world(kind, 1000 * drive.seed + place)
    draw = np.random.default_rng([drive.seed, place, 29])
    course = drawn_course(draw, world.eye, _SPEED[kind], _SWAY_ON_LAND if kind == "street" else _SWAY_AFLOAT)
    moving = _moving(kind, draw, world.eye) if drive.moving else ()
    cameras = drive.rig.left, drive.rig.right
    directions = [pixel_rays(camera) for camera in cameras]
    gains = 1.0, 1.0 + float(np.random.default_rng([drive.seed, 7]).uniform(-_EXPOSURE, _EXPOSURE))
    images = np.empty((len(frames), 2, *directions[0].shape[:2]), np.uint8)
    for number, frame in enumerate(frames):
        rig = drive.truth(frame)
        for side in (0, 1):
            time = number + (drive.late[frame] if side else 0.0)
            shown = replace(world, patches=(*world.patches, *(patch.moved(time * way) for patch, way in moving)))
            rays = world_rays(course(time), rig, side, directions[side], 1.0 / float(cameras[side].focal[0]))
            falling = np.random.default_rng([drive.seed, frame, side, 1])
            light = radiance(shown, rays, time * _SECONDS_PER_FRAME)
            light = _lit(light, weather, falling, np.random.default_rng([drive.seed, side, 2]))
            noise = _NIGHT_NOISE if weather == "night" else _NOISE
            how = {"gain": gains[side], "centre": cameras[side].middle, "noise": noise}
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


def _lit(light: Texture, weather: str, falling: np.random.Generator, glass: np.random.Generator) -> Texture:
    """The light as it reaches one camera.

    Args:
        falling: draws what differs from frame to frame and from camera to camera: streaks.
        glass: draws what stays on this camera's glass: drops.
    """
    if weather == "night":
        return np.asarray(light * np.float32(_NIGHT))
    if weather != "rain":
        return light
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
