"""What the node does, without ROS: images and camera_info go in; calibrations, events and a status come out."""

import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from stereorecal import InputError, StereoRig, View
from stereorecal.geometry import rig_as_data
from stereorecal.io import back_up, calibration_files, load_rig, save_rig
from stereorecal.online import Event, Kind, MonitorProcess, State, reading, recalibrate
from stereorecal_ros._applied import Applied
from stereorecal_ros._camera_info import CameraInfo, corrected, is_like, rig_of, side_by_side, view_of
from stereorecal_ros._camera_info_files import infos_in
from stereorecal_ros._given import Given
from stereorecal_ros._heard import Heard
from stereorecal_ros._images import grey_images
from stereorecal_ros._kept import Kept
from stereorecal_ros._log import Level, Tell, numbers
from stereorecal_ros._pairing import SIDES, Pairing
from stereorecal_ros._requests import frozen, returned
from stereorecal_ros._settings import Settings
from stereorecal_ros._status import Status, status_of
from stereorecal_ros._worker import Begun, Process, Worker

_RECENT = 4  # pairs, which a recalibration on request rests on
_SPACING = 1_000_000_000  # nanoseconds between them, at least: other views of the scene
_RECENT_FOR = 30.0  # seconds, after which the rig may stand otherwise
_SAVE_AGAIN = 10.0  # seconds, after which what could not be kept is tried again
_OUTCOMES = (Kind.RECALIBRATED, Kind.REJECTED, Kind.REFUSED)

Answer = tuple[bool, str]
"""The answer to a request: whether it is done or begun, and what to say."""


@dataclass(frozen=True, eq=False)
class _Recent:
    """A pair: its stamp, when it came by the clock, and its images."""

    stamp: int
    came: float
    images: tuple[np.ndarray, np.ndarray]


class Watch:
    """A rig that is watched. Nothing waits here: a process of its own works, `stereorecal.online.MonitorProcess`.

    The calibration that is published changes by `apply` and `roll_back` alone, and where `auto_apply` is set; it is
    always one that was given, or that the decision has accepted.

    Args:
        settings: the parameters of the node.
        kept: where the state is kept, and what has been applied.
        tell: what is called with lines for the log.
        about: what else to say of an input that is silent, by its name.
        work, clock, background: for tests.

    Raises:
        InputError: if the calibration file cannot be used, or the place of the state is somebody else's.
    """

    def __init__(
        self,
        settings: Settings,
        kept: Kept,
        tell: Tell,
        *,
        about: Callable[[str], str] = lambda name: "",
        work: Callable[..., Process] = MonitorProcess,
        clock: Callable[[], float] = time.monotonic,
        background: Executor | None = None,
    ) -> None:
        kept.check()
        self.settings = settings
        self._kept, self._tell, self._about, self._clock = kept, tell, about, clock
        self._worker = Worker(settings, kept, tell, work, clock, background or ThreadPoolExecutor(1))
        self._pairing = Pairing(round(settings.tolerance * 1e9))
        self._heard, self._given = Heard(settings.silent_after), Given()
        self._rig: StereoRig | None = None  # the one that is given
        self._saved: StereoRig | None = None  # the one that will be given, once the drivers have taken it
        self._view: View | None = None
        self._state: State | None = None
        self._applied: Applied | None = None
        self._corrected: tuple[CameraInfo, CameraInfo] | None = None
        self._infos: tuple[CameraInfo, CameraInfo] | None = None  # as the drivers gave them
        self._recent: deque[_Recent] = deque(maxlen=_RECENT)
        self._asked = False
        self._told_at = clock()
        self._used = self._dropped = self._refused = 0
        self._complaint: str | None = None  # of what comes in
        self._bad: str | None = None  # why the last pairs cannot be used, as the worker says
        self._unsaved: str | None = None  # why the state cannot be kept
        self._unkept: tuple[str, float] | None = None  # why what is applied cannot be, and when it was tried
        if settings.files:
            rig, infos = side_by_side(load_rig(settings.files)), infos_in(settings.files)
            self._adopt(rig, None if infos is None else view_of(*infos))

    @property
    def corrected(self) -> tuple[CameraInfo, CameraInfo] | None:
        """The CameraInfo to publish, of the left and the right camera; None before there is a calibration, and until
        it is known what had been applied to it."""
        return self._corrected

    @property
    def rig(self) -> StereoRig | None:
        """The calibration that is published."""
        if self._rig is None or self._state is None or self._applied is None:
            return self._rig
        return replace(self._state.rig_at(self._applied.offset), source=self._rig.source)

    @property
    def change(self) -> str:
        """From the calibration that was given to the one that is published, for a log."""
        return "" if self._rig is None or self.rig is None else f"{numbers(self._rig)} -> {numbers(self.rig)}"

    def camera_info(self, side: int, message: Any) -> None:
        """A `CameraInfo` of one side has come."""
        now = self._clock()
        self._heard.note(f"{SIDES[side]}/camera_info", now)
        try:
            self._given = self._given.with_info(side, CameraInfo.of(message), now)
        except InputError as error:
            self._complain(f"{SIDES[side]}/{error}")

    def image(self, side: int, stamp: int, message: Any) -> None:
        """An image of one side has come, with its stamp in nanoseconds."""
        now, jumps, newest = self._clock(), self._pairing.jumps, self._pairing.newest[side]
        self._heard.note(f"{SIDES[side]}/image_raw", now)
        self._pairing, pair = self._pairing.with_image(side, stamp, message)
        if self._pairing.newest[side] != newest:
            self._heard.note(f"{SIDES[side]}/stamps", now)
        if self._pairing.jumps > jumps:
            self._recent.clear()
            self._tell(Level.WARN, "the stamps jumped back in time; pairing starts again.")
        if pair is not None:
            self._heard.note("pairs", now)
            self._hand_over(stamp, *pair)

    def poll(self) -> tuple[Event, ...]:
        """What has happened since this was asked before; to be asked several times a second."""
        self._follow_camera_info()
        if self._rig is not None and not self._worker.runs:
            begun = self._worker.start(self._rig, self._applied)
            if begun is not None:
                self._start(self._rig, begun)
        if self._unkept is not None and self._applied is not None and self._clock() >= self._unkept[1] + _SAVE_AGAIN:
            self._keep(self._applied)
        latest = self._worker.latest()
        if latest is None:
            self._asked = False
            return ()
        state, events = latest
        if self._state is None or state.seen != self._state.seen:
            self._told_at, self._bad = self._clock(), None
        self._state = state
        for event in events:
            self._follow(event)
        self._apply_accepted()
        return events

    def status(self) -> Status:
        """How the rig stands under the calibration that is published."""
        state, applied, pairing = self._state, self._applied, self._pairing
        found, waits = None, False
        if state is not None and applied is not None:
            waits = applied.waits(state)
            if not np.array_equal(state.using, applied.offset):  # nor is the last epipolar error of what is published
                state = state.replace(using=applied.offset, row_error=float("nan"))
            found = reading(state) if state.seen else None
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
        age = None if found is None else self._clock() - self._told_at
        unsaved = self._unsaved if self._unkept is None else self._unkept[0]
        return status_of(
            found,
            missing=self._missing(),
            waits=waits,
            dead=self._worker.dead,
            unsaved=unsaved,
            age=age,
            counts=counts,
        )

    def recalibrate(self) -> Answer:
        """Recalibrate on the last pairs; the outcome is an event."""
        if not self._worker.runs:
            return False, self._worker.dead or "there is no calibration yet; nothing to start from."
        while self._recent and self._clock() - self._recent[0].came > _RECENT_FOR:
            self._recent.popleft()
        if not self._recent:
            return False, f"no recent pair: none that shows the rig as it is has come in the last {_RECENT_FOR:.0f} s."
        if self._asked:
            return False, "a recalibration is under way."
        pairs = tuple(recent.images for recent in self._recent)
        self._asked = self._worker.change(partial(recalibrate, pairs=pairs))
        if not self._asked:
            return False, self._worker.dead or "the worker process exited."
        return True, f"begun on the last {len(pairs)} pairs; the result is published as an event."

    def apply(self) -> Answer:
        """Publish what the decision has accepted."""
        if self._state is None or self._applied is None or not self._applied.waits(self._state):
            return False, "no accepted calibration waits; nothing to apply."
        return True, self._publish(self._applied.apply(self._state), "applied")

    def roll_back(self) -> Answer:
        """Publish the calibration before again, and look for no other until `repair` is set."""
        if self._applied is None:
            return False, "there is no calibration yet."
        try:
            applied = self._applied.roll_back()
        except InputError as error:
            return False, str(error)
        said = self._publish(applied, "rolled back")
        self.settings = replace(self.settings, repair=False)
        self._worker.change(partial(returned, offset=applied.offset))
        return True, said

    def save(self) -> Answer:
        """Write the calibration that is published into the file that it was read from; the old one is kept beside."""
        rig = self.rig
        files = calibration_files(rig)
        if rig is None or not files:
            return False, "the calibration came from no file."
        try:
            kept = [str(back_up(path)) for path in files]
            save_rig(rig, files, overwrite=True)
        except InputError as error:
            self._tell(Level.ERROR, f"not saved: {error}")
            return False, str(error)
        said = f"saved in {', '.join(map(str, files))}: {self.change}; the old one is kept as {', '.join(kept)}."
        self._tell(Level.WARN, said)
        self._give(rig)
        return True, said

    def set(self, **changed: bool) -> None:
        """Change `auto_apply` or `repair`."""
        before, self.settings = self.settings, replace(self.settings, **changed)
        for name, value in changed.items():
            if value != getattr(before, name):
                self._tell(Level.WARN, f"{name}: {getattr(before, name)} -> {value}")
        if self.settings.repair != before.repair and self._applied is not None:
            self._keep(replace(self._applied, frozen=not self.settings.repair))
            self._worker.change(partial(frozen, frozen=not self.settings.repair))
        self._apply_accepted()

    def asked_to_save(self) -> None:
        """The drivers are asked to take what is published: it will come back from them as what is given."""
        self._saved = self.rig

    def close(self) -> None:
        """End the worker process; the last state is saved."""
        for event in self._worker.close():
            self._follow(event)

    def _follow_camera_info(self) -> None:
        infos = self._given.new(self._clock())
        if infos is None:
            return
        self._given = self._given.followed()
        if self._halves(infos):
            self._complain("the drivers give the halves of two calibrations; give both the same, or save again.")
            return
        try:
            rig = rig_of(*infos)
        except InputError as error:
            self._complain(str(error))
        else:
            self._adopt(rig, view_of(*infos))
            self._infos = infos

    def _halves(self, infos: Sequence[CameraInfo]) -> bool:
        """Whether one driver gives what was given before, and the other what is published since: a save half done."""
        given, now = self._infos, self._corrected
        if given is None or now is None:
            return False
        # A view of their own may come with them: which camera stands how is in R.
        old, new = (
            [one.is_like(replace(other, p=one.p)) for one, other in zip(infos, some, strict=True)]
            for some in (given, now)
        )
        return any(old) and any(new) and not all(old) and not all(new)

    def _adopt(self, rig: StereoRig, view: View | None) -> None:
        """Begin with a calibration, unless it is the one that is given already, or that was saved. One that was given
        or in use before that is another one: somebody wants it back."""
        if self._rig is not None:
            if is_like(rig, self._rig):
                return
            if any(known is not None and is_like(rig, known) for known in (self.rig, self._saved)):
                self._give(rig)
                return
            self._tell(
                Level.WARN, f"another calibration is given: {self.change or numbers(self._rig)} -> {numbers(rig)}"
            )
        self._rig, self._view, self._corrected = rig, view, None
        self._state = self._applied = self._saved = None
        self._recent.clear()
        self._bad = None
        self._worker.end(None)

    def _give(self, rig: StereoRig) -> None:
        """What was saved is what is given from now on."""
        self._rig = rig
        if self._applied is not None:
            self._keep(replace(self._applied, given=rig))

    def _start(self, rig: StereoRig, begun: Begun) -> None:
        """Watch, with what was applied when the rig was watched before."""
        state, applied = begun.state, begun.applied
        if state is None:
            self._corrected = corrected(rig, self._view)
            return
        if applied is None or rig_as_data(applied.initial) != rig_as_data(state.initial):
            known = (np.zeros(5), state.using, *state.previous)
            apart = [np.abs(state.rig_at(offset).extrinsics - rig.extrinsics).max() for offset in known]
            applied = Applied(state.initial, rig, (known[int(np.argmin(apart))],))
        self._state, self._applied, self._told_at = state, applied, self._clock()
        if applied.frozen and self.settings.repair:
            self.settings = replace(self.settings, repair=False)
            self._tell(Level.WARN, "repair: True -> False, as it was left.")
        if not is_like(rig, applied.given):  # it was saved
            self._give(rig)
        self._corrected = corrected(state.rig_at(applied.offset), self._view)
        if begun.failed is not None:
            return
        self._tell(Level.OK, f"watching from {numbers(state.rig_at(applied.offset))}, after {state.frame} pairs.")
        repairs = state.config.repair
        if applied.returning:  # the process that was asked to did not come to it
            self._applied, repairs = replace(self._applied, returning=1), False
            self._worker.change(partial(returned, offset=applied.offset))
        if repairs != self.settings.repair:
            self._worker.change(partial(frozen, frozen=not self.settings.repair))

    def _hand_over(self, stamp: int, left: Any, right: Any) -> None:
        """A pair that nobody could look at now is not even decoded."""
        if self._rig is None or not self._worker.ready:
            self._dropped += 1
            return
        try:
            images = grey_images(left, right, self._rig)
        except InputError as error:
            self._refused += 1
            self._complain(str(error))
            return
        if not self._worker.put(images, stamp * 1e-9):
            return
        self._used += 1
        self._complaint = None
        if not self._recent or stamp - self._recent[-1].stamp >= _SPACING:
            self._recent.append(_Recent(stamp, self._clock(), images))

    def _follow(self, event: Event) -> None:
        if event.kind is Kind.KNOCK:
            self._recent.clear()  # they show another rig
        if event.kind in _OUTCOMES:
            self._asked = False
        if event.kind is Kind.ROLLED_BACK and self._applied is not None and self._applied.returning:
            self._keep(self._applied.returned())
        if event.kind in (Kind.NOT_SAVED, Kind.SAVED):
            self._unsaved = event.why or None
        if event.kind is Kind.BAD_FRAME:
            before, self._bad = self._bad, f"{event.kind.value}: {event.why}"
            if self._bad != before:  # once, though many pairs are alike
                self._tell(Level.ERROR, self._bad)
        else:
            self._tell(Level.OK if event.kind is Kind.HEALTHY else Level.WARN, str(event).strip())

    def _apply_accepted(self) -> None:
        settings, state, applied = self.settings, self._state, self._applied
        if state is None or applied is None or not (settings.auto_apply and settings.repair):
            return
        if state.config.repair and applied.waits(state):
            self._publish(applied.apply(state), "applied by itself")

    def _publish(self, applied: Applied, how: str) -> str:
        before = self.rig
        self._keep(applied)
        after = self.rig
        assert before is not None
        assert after is not None
        self._corrected = corrected(after, self._view)
        said = f"{how}: {numbers(before)} -> {numbers(after)}"
        self._tell(Level.WARN, said)
        return said

    def _keep(self, applied: Applied) -> None:
        self._applied, before = applied, self._unkept
        try:
            applied.save(self._kept.applied)
        except InputError as error:
            self._unkept = str(error), self._clock()
            if before is None:
                self._tell(Level.ERROR, f"what is applied cannot be kept over a restart: {error}")
        else:
            self._unkept = None

    def _complain(self, what: str) -> None:
        """Once, until something else is wrong, or nothing is."""
        if what != self._complaint:
            self._complaint = what
            self._tell(Level.ERROR, what)

    def _missing(self) -> list[str]:
        """Inputs that are silent; where none is, what else is lacking."""
        now, pairing = self._clock(), self._pairing
        topics = ("image_raw",) if self.settings.files else ("image_raw", "camera_info")
        missing = self._heard.missing([f"{side}/{topic}" for topic in topics for side in SIDES], now)
        if missing:
            return [f"{name}{self._about(name)}" for name in missing]
        still = [side for side in SIDES if self._heard.missing([f"{side}/stamps"], now)]
        if still:
            images = " and ".join(f"{side}/image_raw" for side in still)
            return [f"stamps of {images} (they stay the same; the driver must stamp each image with its time)"]
        if self._rig is None:
            return [f"a calibration ({self._complaint})"]
        if self._corrected is None:
            return ["the worker process, which is being started"]
        if self._heard.missing(["pairs"], now):
            apart = "not known" if pairing.apart is None else f"{pairing.apart / 1e6:.1f} ms"
            return [f"pairs (stamps are {apart} apart, the tolerance is {pairing.tolerance / 1e6:.1f} ms)"]
        wrong = self._complaint or self._bad
        return [] if wrong is None else [f"images that can be used ({wrong})"]
