"""The content of the page of a repair, as plain data: numbers, text and arrays."""

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float


class Conclusion(enum.Enum):
    """What to do with the calibration that a repair started from."""

    REPAIRED = "it is replaced"
    GOOD = "it stays, since it is good"
    REFUSED = "it stays, since no significant improvement was found; it is not known to be good"
    UNKNOWN = "it stays, since the images do not determine it"


@dataclass(frozen=True, eq=False)
class Sight:
    """A rectified pair under one calibration, and its disparity.

    Attributes:
        left, right: (h, w) grey images, 0..255.
        disparity: (h, w) in pixels.
        valid: (h, w), where there is one.
    """

    left: Float[np.ndarray, "h w"]
    right: Float[np.ndarray, "h w"]
    disparity: Float[np.ndarray, "h w"]
    valid: Bool[np.ndarray, "h w"]


@dataclass(frozen=True, eq=False)
class Rows:
    """Row differences of matches, in pixels.

    Attributes:
        field_before, field_after: (h, w) medians over cells of the view, of the frame that is shown; NaN where
            nothing matched.
        all_before, all_after: (m,) of all frames.
    """

    field_before: Float[np.ndarray, "h w"]
    field_after: Float[np.ndarray, "h w"]
    all_before: Float[np.ndarray, "m"]
    all_after: Float[np.ndarray, "m"]


@dataclass(frozen=True)
class Change:
    """The change of a parameter.

    Attributes:
        name, unit: as people write them.
        before, change: values.
        half_width: of the 95 % interval of the change; None if it is not known.
        observed: whether the images determine it.
        digits: with which it is written.
    """

    name: str
    unit: str
    before: float
    change: float
    half_width: float | None
    observed: bool
    digits: int = 3

    @property
    def after(self) -> float:
        """The value of the candidate."""
        return self.before + self.change


@dataclass(frozen=True, eq=False)
class RepairReport:
    """The content of the page.

    Attributes:
        name: of the recording.
        conclusion: what to do with the calibration.
        verdict, advice: what was found, and what to do, in words.
        text: all that is printed of it.
        search: how the search ended, in words.
        baseline: distance between the cameras, in metres.
        facts: of the whole, name and value of both calibrations, such as matched pixels.
        frame: name of the pair that is shown.
        before, after: that pair, under the initial calibration and under the candidate.
        rows: None if none were measured.
        misfit: None or the plain data of a misfit; its regions are numbered by rows of 8 by 6.
        expected: (h, w) half width of the 95 % interval around zero of the epipolar errors of the calibration to use,
            over the view; NaN where not both cameras see the point.
        expected_said: the expectations in a sentence.
        axes, intrinsics: tables, intrinsics with their camera; empty where the candidate means nothing, or nothing was
            refined.
        depths: errors of depth at some distances, each of the calibration that the repair started from and of the one
            to use, with `distance` in metres and the ends `low` and `high` of their 95 % intervals in `percent` and in
            `metres`. None where the candidate was found to be wrong.
        frames: each pair's name, whether it was used, and why not.
        remarks: sentences, such as which directions are unobservable.
        command: as it can be pasted into a shell; None if the repair was no command.
        settings: what is needed to run it again, by name.
        calibrations: before and after, by title, as the text of a calib.json.
        view: in which the pair is shown, in words; None: a pinhole's, which straight things stay straight in.
        searched: False of a look, which changes nothing.
    """

    name: str
    conclusion: Conclusion
    verdict: str
    advice: str
    text: str
    search: str
    baseline: float
    facts: Mapping[str, tuple[str, str]]
    frame: str
    before: Sight
    after: Sight
    rows: Rows | None
    misfit: Mapping[str, Any] | None
    expected: Float[np.ndarray, "h_e w_e"] | None
    expected_said: str | None
    axes: Sequence[Change]
    intrinsics: Sequence[tuple[str, Change]]
    depths: Sequence[tuple[Any, Any]]
    frames: Sequence[tuple[str, str, str]]
    remarks: Sequence[str]
    command: str | None
    settings: Mapping[str, Any]
    calibrations: Mapping[str, str]
    view: str | None = None
    searched: bool = True

    @property
    def accepted(self) -> bool:
        """Whether the candidate is used."""
        return self.conclusion is Conclusion.REPAIRED

    @property
    def names(self) -> tuple[str, str]:
        """What both calibrations are called."""
        return ("before", "after") if self.accepted else ("kept", "candidate")

    @property
    def when(self) -> str:
        """Which calibration is to be used: that "before" the repair, or "after"."""
        return "after" if self.accepted else "before"
