"""A rig that was calibrated on simulated chessboards, and drifted since, as judge."""

from dataclasses import dataclass
from typing import ClassVar

from stereorecal.cli import checked_choice
from stereorecal.geometry import view
from stereorecal.synthetic import KINDS, render
from stereorecal_field.judges._case import DEFAULT_PRIOR, AbstractRecipe, Case
from stereorecal_field.judges._draws import Draws
from stereorecal_field.judges._simulated_calibration import calibrated, true_rig
from stereorecal_field.judges._true_rig import ByTrueRig


@dataclass(frozen=True)
class Simulated(AbstractRecipe):
    """A rig that OpenCV calibrated on simulated chessboards, and that drifted since, in a rendered scene: what users
    hand over. Nobody knows its intrinsics exactly.

    Attributes:
        kind: of scene; the draw is its seed, too.
        frames: how many pairs.
    """

    judge: ClassVar[str] = "simulated"
    judged_by: ClassVar[str] = (
        "a rig that OpenCV calibrated on simulated chessboards, and that drifted, in a rendered scene; by the true rig"
    )

    kind: str
    frames: int

    def make(self) -> Case:
        number = self.seed + (self.draw or 0)
        before = true_rig(number)
        start = calibrated(before, number)
        truth = self.drifted(before)
        scene = render(self.kind, number, rig=truth, frames=self.frames)
        return Case(start, scene.pairs, DEFAULT_PRIOR, ByTrueRig(truth, view(start)))


def simulated_recipes(kind: str, draws: Draws) -> tuple[Simulated, ...]:
    """The recipes of drawn rigs, in scenes of a kind."""
    kind = checked_choice(kind, list(KINDS), "kind of scene") if kind else draws.kinds[0]
    return tuple(Simulated(kind, draw, *draws.drift, kind, draws.frames) for draw in range(draws.number))
