"""Which calibration is published, and what was before it, over restarts."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from stereorecal import InputError, StereoRig
from stereorecal.geometry import rig_as_data
from stereorecal.io import read_json, write_json
from stereorecal.online import State

SCHEMA = "stereorecal.ros-applied/1"
_KEPT = 8

Offset = Float[np.ndarray, "5"]
"""Of a calibration from the one that a state began with, as `State.using`: degrees and percent of the baseline."""


@dataclass(frozen=True, eq=False)
class Applied:
    """The calibrations that have been published, the last one being in use. Only `apply` adds one.

    Attributes:
        initial: the calibration that offsets count from.
        offsets: of the calibrations, the last one last; at most eight.
        frozen: whether nothing is applied by itself, as after a roll back.
        not_accepted: what a state uses that was begun anew and does not know what is published: no decision has
            accepted that.
    """

    initial: StereoRig
    offsets: tuple[Offset, ...]
    frozen: bool = False
    not_accepted: Offset | None = None

    @property
    def offset(self) -> Offset:
        """Of the calibration in use."""
        return self.offsets[-1]

    def waits(self, state: State) -> bool:
        """Whether the decision has accepted another calibration than the one that is published."""
        begun = self.not_accepted is not None and np.array_equal(state.using, self.not_accepted)
        return not begun and not np.array_equal(state.using, self.offset)

    def beside(self, state: State) -> "Applied":
        """The same beside a state that goes on: one that does not know what is published offers nothing of its own."""
        known = any(np.array_equal(self.offset, offset) for offset in (state.using, *state.previous))
        return replace(self, not_accepted=None if known else state.using)

    def apply(self, state: State) -> "Applied":
        """What the decision has accepted is published from now on."""
        return replace(self, offsets=(*self.offsets, state.using)[-_KEPT:]) if self.waits(state) else self

    def roll_back(self) -> "Applied":
        """The calibration before it again, and frozen.

        Raises:
            InputError: if there is none.
        """
        if len(self.offsets) < 2:
            raise InputError("nothing has been applied; there is nothing to take back.")
        return replace(self, offsets=self.offsets[:-1], frozen=True)

    def save(self, path: Path) -> None:
        """Write it, whole or not at all.

        Raises:
            InputError: if the place cannot be written to.
        """
        offsets = [offset.tolist() for offset in self.offsets]
        write_json(
            path, {"schema": SCHEMA, "initial": rig_as_data(self.initial), "offsets": offsets, "frozen": self.frozen}
        )


def load_applied(path: Path, state: State) -> Applied | None:
    """What `save` wrote; None if there is no such file, or it is of another calibration than the state.

    Raises:
        InputError: if the file cannot be read.
    """
    if not path.exists():
        return None
    content = read_json(path)
    try:
        if content["schema"] != SCHEMA or content["initial"] != rig_as_data(state.initial):
            return None
        offsets = tuple(np.array(offset, float).reshape(5) for offset in content["offsets"])
        if not offsets or not all(np.isfinite(offset).all() for offset in offsets):
            raise ValueError("no offsets")
        return Applied(state.initial, offsets, bool(content["frozen"]))
    except (LookupError, TypeError, ValueError) as error:
        raise InputError(f"{path}: does not say what was applied ({error}); remove it.") from error
