"""Which calibration is published, and what was before it, over restarts."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Float

from stereorecal import InputError, StereoRig
from stereorecal.geometry import rig_as_data, rig_from_data
from stereorecal.io import read_json, write_json
from stereorecal.online import Config, State, init
from stereorecal_ros._camera_info import is_like

SCHEMA = "stereorecal.ros-applied/2"
_KEPT = 8

Offset = Float[np.ndarray, "5"]
"""What a calibration differs by from the one that a state began with, as `State.using`: degrees and percent of the
baseline."""


@dataclass(frozen=True, eq=False)
class Applied:
    """The calibrations that have been published, the last one being in use. Only `apply` adds one.

    Attributes:
        initial: the calibration that offsets count from.
        given: the calibration that the files or the drivers said last.
        offsets: of the calibrations, the last one last; at most eight.
        frozen: whether nothing is applied by itself, as after a roll back.
        returning: how many times it was rolled back without the worker having done the same: until then, what was
            taken back looks like a calibration that waits.
    """

    initial: StereoRig
    given: StereoRig
    offsets: tuple[Offset, ...]
    frozen: bool = False
    returning: int = 0

    @property
    def offset(self) -> Offset:
        """The offset of the calibration in use."""
        return self.offsets[-1]

    @cached_property
    def published(self) -> State:
        """A state that uses it."""
        # What the calibration left takes half a second to find, and says nothing of what is used.
        return init(self.initial, Config(prior="exact")).replace(using=self.offset)

    def goes_on(self, rig: StereoRig) -> bool:
        """Whether a calibration that is given now is the one that was given before, or that is published and has been
        saved: any other one was given on purpose, even one that has been in use."""
        return is_like(rig, self.given) or is_like(rig, self.published.rig)

    def waits(self, state: State) -> bool:
        """Whether the decision has accepted another calibration than the one that is published. What a state uses that
        was begun anew, and has switched nothing yet, no decision has accepted."""
        return bool(state.previous) and not self.returning and not np.array_equal(state.using, self.offset)

    def apply(self, state: State) -> "Applied":
        """What the decision has accepted is published from now on."""
        first, *later = (*self.offsets, state.using)
        return replace(self, offsets=(first, *later[1 - _KEPT :])) if self.waits(state) else self

    def roll_back(self) -> "Applied":
        """The calibration before it again, and frozen.

        Raises:
            InputError: if there is none.
        """
        if len(self.offsets) < 2:
            raise InputError("nothing has been applied; there is nothing to take back.")
        return replace(self, offsets=self.offsets[:-1], frozen=True, returning=self.returning + 1)

    def returned(self) -> "Applied":
        """After the worker has rolled back once as well."""
        return replace(self, returning=max(self.returning - 1, 0))

    def save(self, path: Path) -> None:
        """Write it, whole or not at all.

        Raises:
            InputError: if the place cannot be written to.
        """
        content = {
            "schema": SCHEMA,
            "initial": rig_as_data(self.initial),
            "given": rig_as_data(self.given),
            "offsets": [offset.tolist() for offset in self.offsets],
            "frozen": self.frozen,
            "returning": self.returning,
        }
        write_json(path, content)


def load_applied(path: Path) -> Applied | None:
    """What `save` wrote; None if there is no such file.

    Raises:
        InputError: if the file cannot be read, or holds something else.
    """
    if not path.exists():
        return None
    content = read_json(path)
    try:
        if content["schema"] != SCHEMA:
            raise ValueError(f"it is of version {content['schema']!r}")
        initial, given = (rig_from_data(content[name]) for name in ("initial", "given"))
        offsets = tuple(np.array(offset, float).reshape(5) for offset in content["offsets"])
        if not offsets or not all(np.isfinite(offset).all() for offset in offsets):
            raise ValueError("no offsets")
        return Applied(initial, given, offsets, bool(content["frozen"]), int(content["returning"]))
    except (InputError, LookupError, TypeError, ValueError) as error:
        raise InputError(f"{path}: does not say what was applied ({error}); remove it.") from error
