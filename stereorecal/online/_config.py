"""What can be set on the vehicle, and what happens there, as plain data."""

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any

import numpy as np

from stereorecal._arrays import json_data
from stereorecal._errors import InputError, checked_choice
from stereorecal.decision import DEFAULT as USUAL, Tolerances, as_tolerances
from stereorecal.estimation import DEFAULT, EXACT
from stereorecal.geometry import checked_view_arguments
from stereorecal.matching import AbstractMatcher

EVENTS_SCHEMA = "stereorecal.events/1"
# Chance that a switch does harm, at most, and that it does not gain; and the share of the loss that it must gain. More
# than in a recording, since later pairs can correct it.
_HARM = 0.2
_GAINS = 0.2  # of what a change has to gain in a recording, whose repair somebody takes over by hand


def _is_whole(value: Any, least: int) -> bool:
    return isinstance(value, Real) and float(value).is_integer() and float(value) >= least


def _is_spread(value: Any) -> bool:
    try:
        numbers = np.asarray(value, float)
    except ValueError:
        return False
    return bool(np.all((numbers >= 0.0) & np.isfinite(numbers)))


_CHECKS: tuple[tuple[tuple[str, ...], Callable[[Any], bool], str], ...] = (
    (("synchronous", "motion", "repair"), lambda value: isinstance(value, bool | np.bool_), "True or False"),
    (("every", "together"), lambda value: _is_whole(value, 1), "a whole number, at least 1"),
    (("rest",), lambda value: _is_whole(value, 0), "a whole number, at least 0"),
    (("shift",), lambda value: isinstance(value, Real), "a number"),
    (("wander", "heating"), lambda value: np.shape(value) == (3,), "three numbers, of pitch, yaw and roll"),
    (("wander", "shift", "heating"), _is_spread, "0 or more"),
)


@dataclass(frozen=True)
class Config:
    """How a rig is watched and repaired. Times are counted in pairs, so that the same pairs give the same states.

    Attributes:
        matcher: a matcher, or the name of an installed one (default "sad"); without `num_disparities` the range is
            measured on the first pairs that show something.
        projection, field: of the view of all looks, as `sr.view(rig)` has them; None: its default.
        every: a look at every so many pairs; the others only tell how the rig moves.
        wander: standard deviations of what pitch, yaw and roll jump by from one pair to the next, degrees: vibration.
        shift: the same of y and z, percent of the baseline.
        heating: standard deviations of the rates at which they drift one way for a while, degrees a pair. Heat bends
            the bar between the cameras, which is yaw, more than it twists it. How much more or less than this and
            `wander` it is, is learnt from how far looks lie from what was predicted.
        prior: of what the calibration left: "default" (also for None), as a chessboard calibration of this rig: lenses
            that are not what it says bend rows as a yaw does, which the rig's motion tells apart; or "exact": they are
            right, and rows alone tell the yaw.
        synchronous: a trigger opens both shutters at once, so none is late: what the rig's turn would hide behind a
            delay is known, and y and z are switched, too.
        motion: whether the rig's own motion is followed: pairs come in the order in which they were taken.
        together: looks that err together, since they show the same things in the same windows: each counts for that
            much less in what is fused.
        rest: pairs from one switch to the next, at least: each costs, such as new rectification maps. A knock ends it.
        tolerances: of the decision that a calibration is to be repaired; also some of their values by name.
        repair: False watches alone, and switches nothing: the freeze switch. What moved a rig of which hardly anything
            matches is still searched for, to say it.
    """

    matcher: AbstractMatcher | str | None = None
    projection: str | None = None
    field: float | None = None
    every: int = 1
    wander: tuple[float, float, float] = (2e-4, 4e-4, 2e-4)
    shift: float = 1e-4
    heating: tuple[float, float, float] = (2e-4, 8e-4, 2e-4)
    prior: str | None = None
    synchronous: bool = False
    motion: bool = True
    together: int = 8
    rest: int = 10
    tolerances: Tolerances = USUAL
    repair: bool = True

    def __post_init__(self) -> None:
        checked_choice("default" if self.prior is None else self.prior, [DEFAULT, EXACT], "prior")
        checked_view_arguments(self.view)
        object.__setattr__(self, "tolerances", as_tolerances(self.tolerances))
        for names, holds, wanted in _CHECKS:
            for name in names:
                if not holds(value := getattr(self, name)):
                    raise InputError(f"{name} is {value!r}; give {wanted}.")

    @property
    def limits(self) -> Tolerances:
        """Tolerances of what may be switched: those of a recording where nothing is, and so nothing taken back."""
        surely, gains = 1.0 - _HARM, _GAINS * self.tolerances.gains
        loose = replace(self.tolerances, gains=gains, harm=_HARM, better=surely, leaves=surely)
        return loose if self.repair else self.tolerances

    @property
    def view(self) -> dict[str, str | float | None]:
        """The arguments of `sr.view`, by name."""
        return {"projection": self.projection, "field": self.field}


class Kind(enum.Enum):
    """What an event says; the value is the message."""

    HEALTHY = "the calibration fits the images"
    DRIFTING = "the rig has drifted by more than matters"
    KNOCK = "the rig has been knocked"
    LATE = "one shutter is late: the offset between the cameras follows the rig's own motion; nothing is switched"
    SHIFTED = "the right camera has shifted, or its shutter is late in straight travel; the calibration stays"
    REPAIRING = "a repair has begun"
    REPAIRED = "a better calibration is in use"
    RECALIBRATED = "recalibrated on request: the accepted candidate is in use"
    REJECTED = "no candidate was accepted"
    ROLLED_BACK = "an earlier calibration is in use again, on request; nothing is switched"
    REFUSED = "a request was refused"
    NOT_SAVED = "the state cannot be saved; the rig is watched on, and saving is tried again"
    SAVED = "the state can be saved again"
    FRAMES_DISAGREE = "the frames show different rigs"
    TOO_LITTLE_TEXTURE = "too little light, texture or grey levels"
    BAD_FRAME = "the pair cannot be used"


@dataclass(frozen=True, eq=False)
class Event:
    """Something that happened at a pair.

    Attributes:
        frame: number of the pair, from 0.
        kind: what.
        why: details in words; may be empty.
        facts: details as plain data: axes in degrees and percent of the baseline, calibrations, proofs.
    """

    frame: int
    kind: Kind
    why: str = ""
    facts: Mapping[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        about = {"schema": EVENTS_SCHEMA, "frame": self.frame, "event": self.kind.name.lower()}
        return json_data({**about, "message": self.kind.value, "why": self.why, **self.facts})

    def __str__(self) -> str:
        return f"{self.frame:6d}  {self.kind.value}{f' ({self.why})' if self.why else ''}"
