"""A pair of a mission with the counter of its pixels."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.recordings import Pair, PairSequence, names_of
from stereorecal_paper._pixel_counter import PixelCounter

_WHEN = ("score_initial", "score_final", "score_reference")

Row = dict[str, Any]
"""Plain data: what JSON holds."""


@dataclass(frozen=True, eq=False)
class LoggedPair:
    """One pair of a mission, and the counter of its pixels.

    Attributes:
        frame: the pair, alone, read when it is needed: all together may not fit into the memory.
        starred: whether it shows little to match, such as open sea.
    """

    sequence: str
    frame: PairSequence
    starred: bool
    counter: PixelCounter

    @property
    def pair(self) -> Pair:
        """The pair; lazy pairs are read here."""
        return self.frame[0]

    @property
    def image(self) -> str:
        """Name of the pair."""
        return names_of(self.frame)[0]

    @property
    def key(self) -> str:
        """A name that no other pair of a log has."""
        return f"{self.sequence}/{self.image}"

    @property
    def about(self) -> Row:
        """What every row says of its pair."""
        return {"sequence": self.sequence, "image": self.image, "starred": self.starred}

    def counted(self, *rigs: StereoRig) -> Row:
        """N_i, N_o and N_GT: the counts under the rig before, the rig after, and the manual calibration."""
        extrinsics = [np.asarray(rig.extrinsics) for rig in (*rigs, self.counter.rig)]
        return dict(zip(_WHEN, self.counter.counts(self.pair, extrinsics), strict=True))
