"""What the node does, without ROS: images and camera_info go in, calibrations, events and a status come out."""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereorecal import InputError, StereoRig, View
from stereorecal.io import back_up, calibration_files, image_of_message, load_rig, save_rig
from stereorecal.online import Beside, Config, Event, Kind, State, reading, recalibrate
from stereorecal_ros._applied import Applied, load_applied
from stereorecal_ros._camera_info import CameraInfo, corrected, rig_of, view_of
from stereorecal_ros._pairing import Pairing
from stereorecal_ros._requests import frozen, returned
from stereorecal_ros._settings import Settings
from stereorecal_ros._status import Level, Status, status_of

SIDES = ("left", "right")
_RECENT = 4  # pairs, which a recalibration on request rests on
_SPACING = 1.0  # seconds between them, at least: other views of the scene
_SETTLED = 2.0  # seconds for which camera_info that has changed must stay: a driver changes one after the other
_RETRY, _LONGEST_RETRY = 5.0, 60.0  # seconds until a worker that exited is replaced; doubled each time
_OUTCOMES = (Kind.RECALIBRATED, Kind.REJECTED, Kind.REFUSED)

Answer = tuple[bool, str]
"""Of a request: whether it is done or begun, and what to say."""


class Watch:
    """A rig that is watched. Nothing waits here: the work is done by another process, `stereorecal.online.Beside`.

    The calibration that is published changes by `apply` and `roll_back` alone, and by `auto_apply`; it is always one
    that was given, or that the decision has accepted.

    Args:
        settings: the parameters of the node.
        place: the file in which the state is kept; what has been applied is kept beside it.
        tell: what is called with lines for the log.
        work, clock: for tests.

    Raises:
        InputError: if the calibration file cannot be used.
    """

    def __init__(
        self,
        settings: Settings,
        place: Path,
        tell: Callable[[Level, str], None],
        *,
        work: Callable[..., Beside] = Beside,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.settings = settings
        self._place, self._tell, self._work, self._clock = place, tell, work, clock
        self._pairing = Pairing(round(settings.tolerance * 1e9))
        self._heard: dict[str, float] = {}
        self._infos: list[CameraInfo | None] = [None, None]
        self._info_changed: float | None = None
        self._given: StereoRig | None = None
        self._view: View | None = None
        self._beside: Beside | None = None
        self._ending: threading.Thread | None = None
        self._dead: str | None = None
        self._retry, self._retry_at = _RETRY, clock()
        self._state: State | None = None
        self._applied: Applied | None = None
        self._corrected: tuple[CameraInfo, CameraInfo] | None = None
        self._recent: deque[tuple[int, tuple[np.ndarray, np.ndarray]]] = deque(maxlen=_RECENT)
        self._asked = False
        self._told_at = clock()
        self._used = self._dropped = self._refused = 0
        self._complaint: str | None = None
        if settings.files:
            self._adopt(load_rig(settings.files), None)

    @property
    def corrected(self) -> tuple[CameraInfo, CameraInfo] | None:
        """The CameraInfo to publish, of the left and the right camera; None before there is a calibration."""
        return self._corrected

    @property
    def rig(self) -> StereoRig | None:
        """The calibration that is published."""
        if self._state is None or self._applied is None or self._given is None:
            return self._given
        return replace(self._state.rig_at(self._applied.offset), source=self._given.source)

    def camera_info(self, side: int, message: Any) -> None:
        """A `CameraInfo` of one side has come."""
        self._heard[f"{SIDES[side]}/camera_info"] = self._clock()
        try:
            info = CameraInfo.of(message)
        except InputError as error:
            self._complain(f"{SIDES[side]}/{error}")
            return
        if info != self._infos[side]:
            self._infos[side] = info
            self._info_changed = self._clock()

    def image(self, side: int, stamp: int, message: Any) -> None:
        """An image of one side has come, with its stamp in nanoseconds."""
        self._heard[f"{SIDES[side]}/image_raw"] = self._clock()
        before = self._pairing.jumps
        self._pairing, pair = self._pairing.with_image(side, stamp, message)
        if self._pairing.jumps > before:
            self._recent.clear()
            self._tell(Level.WARN, "time has jumped back; pairs are made anew from now on.")
        if pair is not None:
            self._heard["pairs"] = self._clock()
            self._pair(stamp, *pair)

    def poll(self) -> tuple[Event, ...]:
        """What has happened since this was asked before; to be asked several times a second."""
        self._follow_camera_info()
        if self._beside is None:
            self._start()
        if self._beside is None:
            return ()
        try:
            state, events = self._beside.latest()
        except RuntimeError as error:
            self._end(str(error))
            return ()
        if self._state is None or state.seen != self._state.seen:
            self._told_at, self._retry = self._clock(), _RETRY
        self._state = state
        for event in events:
            self._follow(event)
        self._apply_accepted()
        return events

    def status(self) -> Status:
        """How the rig stands under the calibration that is published."""
        state, pairing = self._state, self._pairing
        found = waits = None
        if state is not None and self._applied is not None:
            waits = self._applied.waits(state)
            found = reading(state.using_now(self._applied.offset)) if state.seen else None
        counts = {
            "pairs": pairing.paired,
            "pairs looked at": self._used,
            "pairs dropped, which could not be followed": self._dropped,
            "pairs refused": self._refused,
            "images without partner": pairing.unpaired,
            "images too late": pairing.late,
            "jumps back in time": pairing.jumps,
            "auto_apply": self.settings.auto_apply,
            "repair": self.settings.repair,
        }
        age = self._clock() - self._told_at if found is not None else None
        return status_of(found, missing=self._missing(), waits=bool(waits), dead=self._dead, age=age, counts=counts)

    def recalibrate(self) -> Answer:
        """Recalibrate on the last pairs; the outcome is an event."""
        if self._beside is None:
            return False, self._dead or "there is no calibration yet; nothing to start from."
        if not self._recent:
            return False, "no pair has come yet."
        if self._asked:
            return False, "a recalibration is under way."
        pairs = tuple(pair for _, pair in self._recent)
        try:
            self._beside.change(partial(recalibrate, pairs=pairs))
        except RuntimeError as error:
            return False, str(error)
        self._asked = True
        return True, f"begun on the last {len(pairs)} pairs; the outcome comes as an event."

    def apply(self) -> Answer:
        """Publish what the decision has accepted."""
        if self._state is None or self._applied is None or not self._applied.waits(self._state):
            return False, "no accepted calibration waits; nothing to apply."
        return True, self._publish(self._applied.apply(self._state), "applied")

    def roll_back(self) -> Answer:
        """Publish the calibration before again, and look for no other until `repair` is set."""
        if self._state is None or self._applied is None:
            return False, "there is no calibration yet."
        try:
            applied = self._applied.roll_back()
        except InputError as error:
            return False, str(error)
        said = self._publish(applied, "rolled back")
        self.settings = replace(self.settings, repair=False)
        self._change(partial(returned, offset=applied.offset))
        return True, said

    def save(self) -> Answer:
        """Write the calibration that is published into the file that it was read from; the old one is kept beside."""
        rig = self.rig
        if self._given is None or rig is None:
            return False, "there is no calibration yet."
        files = calibration_files(self._given)
        if not files:
            return False, "the calibration came from no file."
        try:
            kept = [str(back_up(path)) for path in files]
            save_rig(rig, files, overwrite=True)
        except InputError as error:
            self._tell(Level.ERROR, f"not saved: {error}")
            return False, str(error)
        said = f"saved in {', '.join(map(str, files))}: {_numbers(rig)}; the old one is kept as {', '.join(kept)}."
        self._tell(Level.WARN, said)
        return True, said

    def set(self, **changed: bool) -> None:
        """Change `auto_apply` or `repair`."""
        before, self.settings = self.settings, replace(self.settings, **changed)
        for name, value in changed.items():
            if value != getattr(before, name):
                self._tell(Level.WARN, f"{name}: {getattr(before, name)} -> {value}")
        if self.settings.repair != before.repair and self._applied is not None:
            self._keep(replace(self._applied, frozen=not self.settings.repair))
            self._change(partial(frozen, frozen=not self.settings.repair))
        self._apply_accepted()

    def close(self) -> None:
        """End the worker process; the last state is saved."""
        if self._beside is not None:
            self._beside.close()
        if self._ending is not None:
            self._ending.join()

    def _follow_camera_info(self) -> None:
        """The first calibration at once, another one when it has stayed for a while."""
        left, right = self._infos
        if self._info_changed is None or left is None or right is None:
            return
        if self._given is not None and self._clock() - self._info_changed < _SETTLED:
            return
        self._info_changed = None
        try:
            rig = rig_of(left, right)
            corrected(rig)
        except InputError as error:
            self._complain(str(error))
            return
        self._adopt(rig, view_of(left, right))

    def _adopt(self, rig: StereoRig, view: View | None) -> None:
        """A calibration is given: the first one, or another one."""
        known = [] if self._given is None else [self._given, self.rig]
        if self._state is not None:
            known.append(self._state.rig)
        if any(one is not None and _alike(rig, one) for one in known):
            return
        if self._given is not None:
            self._tell(Level.WARN, f"another calibration is given: {_numbers(self._given)} -> {_numbers(rig)}")
        self._given, self._view = rig, view
        self._corrected = corrected(rig, view)
        self._state = self._applied = None
        self._recent.clear()
        if self._beside is not None:
            self._end(None)

    def _start(self) -> None:
        if self._given is None or self._clock() < self._retry_at:
            return
        if self._ending is not None and self._ending.is_alive():
            return
        config = Config(matcher=self.settings.matcher, repair=self.settings.repair)
        start = partial(
            self._work,
            self._given,
            config,
            keep=self._place,
            keep_every=self.settings.keep_every,
            share=self.settings.share,
        )
        try:
            try:
                self._beside = start()
            except InputError as error:
                if not self._place.exists():
                    raise
                self._set_aside(self._place, error)
                self._beside = start()
            self._begin(self._beside.latest()[0])
        except (InputError, OSError, RuntimeError) as error:
            self._end(str(error))
            return
        self._dead, self._asked, self._told_at = None, False, self._clock()

    def _begin(self, state: State) -> None:
        """With the state that the worker has started from, and what was applied then."""
        applied = None
        try:
            applied = load_applied(self._beside_place, state)
        except InputError as error:
            self._set_aside(self._beside_place, error)
        if applied is None:
            known = (np.zeros(5), state.using, *state.previous)
            apart = [np.abs(state.rig_at(offset).extrinsics - self._rig_given.extrinsics).max() for offset in known]
            applied = Applied(np.asarray(state.initial.extrinsics), (known[int(np.argmin(apart))],))
        if applied.frozen and self.settings.repair:
            self.settings = replace(self.settings, repair=False)
            self._tell(Level.WARN, "repair: True -> False, as it was left: a calibration had been rolled back.")
        self._state, self._applied = state, applied
        self._corrected = corrected(state.rig_at(applied.offset), self._view)
        self._tell(Level.OK, f"watching from {_numbers(state.rig_at(applied.offset))}, after {state.frame} pairs.")
        if state.config.repair != self.settings.repair:
            self._change(partial(frozen, frozen=not self.settings.repair))

    def _end(self, why: str | None) -> None:
        """End the worker, without waiting; another one is started later."""
        if why is not None:
            self._dead = why
            self._tell(Level.ERROR, f"{why} Another try in {self._retry:.0f} s.")
            self._retry_at = self._clock() + self._retry
            self._retry = min(2.0 * self._retry, _LONGEST_RETRY)
        if self._beside is not None:
            self._ending = threading.Thread(target=self._beside.close, daemon=True)
            self._ending.start()
            self._beside = None
        self._asked = False

    def _pair(self, stamp: int, left: Any, right: Any) -> None:
        """A pair that nobody could look at now is not even decoded."""
        if self._beside is None or self._given is None or not self._beside.ready:
            self._dropped += 1
            return
        try:
            images = (_grey(left, "left/image_raw"), _grey(right, "right/image_raw"))
            for side, image, camera in zip(SIDES, images, (self._given.left, self._given.right), strict=True):
                if image.shape[::-1] != camera.size:
                    raise InputError(
                        f"{side}/image_raw: the image is {image.shape[1]}x{image.shape[0]}, and the calibration is of "
                        f"{camera.size[0]}x{camera.size[1]}; publish images of one size."
                    )
            self._beside.put(images)
        except InputError as error:
            self._refused += 1
            self._complain(str(error))
            return
        except RuntimeError:
            return  # poll says so
        self._used += 1
        self._complaint = None
        if not self._recent or stamp - self._recent[-1][0] >= _SPACING * 1e9:
            self._recent.append((stamp, images))

    def _follow(self, event: Event) -> None:
        if event.kind is Kind.KNOCK:
            self._recent.clear()  # they show another rig
        if event.kind in _OUTCOMES:
            self._asked = False
        if event.kind is Kind.BAD_FRAME:
            self._complain(f"{event.kind.value}: {event.why}")
        else:
            self._tell(Level.OK if event.kind is Kind.HEALTHY else Level.WARN, str(event).strip())

    def _apply_accepted(self) -> None:
        settings, state = self.settings, self._state
        if state is None or self._applied is None or not (settings.auto_apply and settings.repair):
            return
        if state.config.repair and self._applied.waits(state):
            self._publish(self._applied.apply(state), "applied by itself")

    def _publish(self, applied: Applied, how: str) -> str:
        before = self.rig
        self._keep(applied)
        after = self.rig
        assert before is not None
        assert after is not None
        self._corrected = corrected(after, self._view)
        said = f"{how}: {_numbers(before)} -> {_numbers(after)}"
        self._tell(Level.WARN, said)
        return said

    def _keep(self, applied: Applied) -> None:
        self._applied = applied
        try:
            applied.save(self._beside_place)
        except InputError as error:
            self._tell(Level.ERROR, f"what is applied cannot be kept over a restart: {error}")

    def _change(self, change: Callable) -> None:
        if self._beside is not None:
            try:
                self._beside.change(change)
            except RuntimeError as error:
                self._end(str(error))

    def _set_aside(self, path: Path, error: InputError) -> None:
        self._tell(Level.WARN, f"{error} It is kept as {back_up(path)}, and a new one begun.")
        path.unlink()

    def _complain(self, what: str) -> None:
        """Once, until something else is wrong, or nothing is."""
        if what != self._complaint:
            self._complaint = what
            self._tell(Level.ERROR, what)

    def _missing(self) -> list[str]:
        """Inputs that are silent; or, where both sides send images, why there are no pairs of them."""
        wanted = [f"{side}/{topic}" for topic in self._topics for side in SIDES]
        missing = [name for name in wanted if self._is_silent(name)]
        if self._given is None and not missing:
            missing.append(f"a calibration ({self._complaint})")
        if not missing and self._is_silent("pairs"):
            apart = "not known" if self._pairing.apart is None else f"{self._pairing.apart / 1e6:.1f} ms"
            missing.append(f"pairs (stamps are {apart} apart, tolerance {self._pairing.tolerance / 1e6:.1f} ms)")
        if not missing and self._complaint is not None:
            missing.append(f"images that can be used ({self._complaint})")
        return missing

    @property
    def _topics(self) -> tuple[str, ...]:
        return ("image_raw",) if self.settings.files else ("image_raw", "camera_info")

    def _is_silent(self, name: str) -> bool:
        at = self._heard.get(name)
        return at is None or self._clock() - at > self.settings.silent_after

    @property
    def _beside_place(self) -> Path:
        return self._place.with_name(f"{self._place.name}.applied.json")

    @property
    def _rig_given(self) -> StereoRig:
        assert self._given is not None
        return self._given


def _grey(message: Any, where: str) -> np.ndarray:
    """(h, w) of 8 or 16 bit."""
    image = image_of_message(message, where)
    if image.ndim == 2:
        return image
    return cv2.cvtColor(image, cv2.COLOR_BGRA2GRAY if image.shape[2] == 4 else cv2.COLOR_BGR2GRAY)


def _alike(one: StereoRig, other: StereoRig) -> bool:
    """Whether two calibrations are one, which may have been written with some digits less."""
    return all(a.is_like(b) for a, b in zip(corrected(one), corrected(other), strict=True))


def _numbers(rig: StereoRig) -> str:
    """The extrinsics, for a log."""
    pitch, yaw, roll = np.degrees(rig.extrinsics[:3])
    x, y, z = 1e3 * np.asarray(rig.extrinsics[3:])
    return f"pitch {pitch:+.4f} yaw {yaw:+.4f} roll {roll:+.4f} deg, x {x:+.3f} y {y:+.3f} z {z:+.3f} mm"
