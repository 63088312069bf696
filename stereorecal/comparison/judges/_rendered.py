"""Judges that are rendered: a scene whose true rig is known, and one whose calibration was made on chessboards."""

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

from stereorecal.comparison.judges._case import AbstractRecipe, Case, prior_of
from stereorecal.comparison.judges._simulated_calibration import calibrated, true_rig
from stereorecal.comparison.judges._true_rig import ByTrueRig
from stereorecal.geometry import view
from stereorecal.recordings import Scene
from stereorecal.synthetic import render


@dataclass(frozen=True)
class Rendered(AbstractRecipe):
    """A drift of the rig of a rendered scene; intrinsics are exact.

    Attributes:
        kind: of scene.
        frames: how many pairs.
    """

    judge: ClassVar[str] = "rendered"

    kind: str
    frames: int

    def make(self) -> Case:
        scene = _scene(self.kind, self.seed, self.frames)
        assert scene.rig is not None
        start = self.drifted(scene.rig)
        return Case(start, scene.pairs, prior_of(exact=True), ByTrueRig(scene.rig, view(start)))


@lru_cache(maxsize=2)
def _scene(kind: str, seed: int, frames: int) -> Scene:
    return render(kind, seed, frames=frames)


@dataclass(frozen=True)
class Simulated(AbstractRecipe):
    """A rig that OpenCV calibrated on simulated chessboards, and that drifted since, in a rendered scene: what users
    hand over. Nobody knows its intrinsics exactly.

    Attributes:
        kind: of scene; the draw is its seed, too.
        frames: how many pairs.
    """

    judge: ClassVar[str] = "simulated"

    kind: str
    frames: int

    def make(self) -> Case:
        number = self.seed + (self.draw or 0)
        before = true_rig(number)
        start = calibrated(before, number)
        truth = self.drifted(before)
        scene = render(self.kind, number, rig=truth, frames=self.frames)
        return Case(start, scene.pairs, prior_of(exact=False), ByTrueRig(truth, view(start)))
