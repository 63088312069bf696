"""The parameters of the node."""

from dataclasses import dataclass, field, fields
from typing import Any

from stereorecal import InputError
from stereorecal.matching import as_matcher

TRANSPORTS = ("raw", "compressed")


def _parameter(default: Any, about: str, *, changes: bool = False) -> Any:
    return field(default=default, metadata={"about": about, "changes": changes})


@dataclass(frozen=True)
class Settings:
    """What can be set. Those that change while the node runs are `auto_apply` and `repair`.

    Raises:
        InputError: if a value makes no sense.
    """

    auto_apply: bool = _parameter(False, "publish what the decision has accepted without being asked to", changes=True)
    repair: bool = _parameter(
        True, "look for a better calibration; false, as after a roll back: watch alone", changes=True
    )
    calibration: tuple[str, ...] = _parameter(
        ("",), "calibration file of any format, or two; without one, the camera_info topics say it"
    )
    transport: str = _parameter("raw", "raw or compressed images")
    tolerance: float = _parameter(0.005, "seconds by which the stamps of a pair may differ")
    share: float = _parameter(0.25, "of one core, that the work may take")
    matcher: str = _parameter("sad", "sad, bm or sgbm")
    synchronous: bool = _parameter(False, "a trigger opens both shutters at once: none is late")
    state_file: str = _parameter("", "where the state is kept over restarts; default in ROS_HOME, by the node's name")
    keep_every: float = _parameter(10.0, "seconds between two savings of the state, unless something has happened")
    silent_after: float = _parameter(2.0, "seconds without a message, after which an input is called missing")

    def __post_init__(self) -> None:
        if self.transport not in TRANSPORTS:
            raise InputError(f"transport is {self.transport!r}; give raw or compressed.")
        for name in ("tolerance", "keep_every"):
            if not 0.0 <= getattr(self, name) < 3600.0:
                raise InputError(f"{name} is {getattr(self, name)}; give seconds, 0 or more.")
        if not self.silent_after > 0.0:
            raise InputError(f"silent_after is {self.silent_after}; give seconds, more than 0.")
        if not 0.0 < self.share <= 1.0:
            raise InputError(f"share is {self.share}; give a part of one core, above 0 and at most 1.")
        if len(self.files) > 2:
            raise InputError(f"calibration names {len(self.files)} files; give one, or that of the left and the right.")
        as_matcher(self.matcher)

    @property
    def files(self) -> tuple[str, ...]:
        """The calibration files."""
        return tuple(name for name in self.calibration if name)


def about(name: str) -> str:
    """What a parameter is for."""
    return _field(name).metadata["about"]


def changes(name: str) -> bool:
    """Whether a parameter may change while the node runs."""
    return _field(name).metadata["changes"]


def _field(name: str):
    return next(one for one in fields(Settings) if one.name == name)
