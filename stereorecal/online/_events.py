"""What happens on the vehicle, as plain data."""

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stereorecal._arrays import json_data

EVENTS_SCHEMA = "stereorecal.events/1"


class Kind(enum.Enum):
    """What an event says; the value is the message."""

    HEALTHY = "the calibration fits the images"
    DRIFTING = "the rig has drifted by more than matters"
    KNOCK = "the rig has been knocked"
    LATE = "one shutter is late: the offset between the cameras follows the rig's own motion; nothing is switched"
    SHIFTED = "the right camera has shifted, or its shutter is late in straight travel; the calibration stays"
    REPAIRING = "a repair has begun"
    REPAIRED = "a better calibration is in use: it wins on pairs that came later than those it was fitted to"
    RECALIBRATED = "recalibrated on request: the accepted candidate is in use"
    REJECTED = "a candidate was rejected"
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
        named = {
            "schema": EVENTS_SCHEMA,
            "frame": self.frame,
            "event": self.kind.name.lower(),
            "message": self.kind.value,
        }
        return json_data({**named, "why": self.why, **self.facts})

    def __str__(self) -> str:
        return f"{self.frame:6d}  {self.kind.value}{f' ({self.why})' if self.why else ''}"
