"""A simulated drive: a moving rig that drifts, warms up and is knocked, in changing weather, with the true rig of each
frame."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from stereorecal import InputError
from stereorecal.geometry import StereoRig
from stereorecal.synthetic._default_rig import default_rig

TOURS = {"harbour": ("harbour", "coast"), "street": ("street",)}
"""Name of each tour and the kinds of scenes that it passes through."""

SIZE = (320, 240)
"""Of the images; the focal length is about 300 pixels."""

_PLACE = 50  # frames at one place: the rig travels a few metres there
_WALK = np.radians(1e-4)  # random walk of each angle, a frame
_WALK_SHIFT = 1e-6  # of y and z, likewise, in baselines
_HEAT = np.radians([0.1, 0.4, 0.1])  # over _WARM frames
_WARM = 500
_WEATHERS = ("clear", "rain", "clear", "night", "clear", "sea")  # of some places in turn
_STRETCH = 2  # places that share one weather


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
        """At which place a frame was taken; places are visited one after the other."""
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
    """Of each frame; the first stretch is always clear."""
    found = []
    for frame in range(frames):
        stretch = frame // (_PLACE * _STRETCH)
        now = "clear" if first is None or stretch == 0 else _WEATHERS[(first + stretch) % len(_WEATHERS)]
        found.append("clear" if now == "sea" and tour != "harbour" else now)
    return tuple(found)
