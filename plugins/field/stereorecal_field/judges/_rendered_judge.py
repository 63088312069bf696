"""A rendered scene as judge, whose true rig is known."""

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

from stereorecal.cli import checked_choice
from stereorecal.estimation import EXACT
from stereorecal.geometry import view
from stereorecal.recordings import Scene
from stereorecal.synthetic import KINDS, render
from stereorecal_field.judges._case import AbstractRecipe, Case
from stereorecal_field.judges._draws import Draws
from stereorecal_field.judges._true_rig import ByTrueRig


@dataclass(frozen=True)
class Rendered(AbstractRecipe):
    """A drift of the rig of a rendered scene; intrinsics are exact.

    Attributes:
        kind: of scene.
        frames: how many pairs.
    """

    judge: ClassVar[str] = "rendered"
    judged_by: ClassVar[str] = "a drift of a rendered scene's rig, intrinsics exact; by the true rig"

    kind: str
    frames: int

    def make(self) -> Case:
        scene = _scene(self.kind, self.seed, self.frames)
        assert scene.rig is not None
        start = self.drifted(scene.rig)
        return Case(start, scene.pairs, EXACT, ByTrueRig(scene.rig, view(start)))


@lru_cache(maxsize=2)
def _scene(kind: str, seed: int, frames: int) -> Scene:
    return render(kind, seed, frames=frames)


def rendered_recipes(kind: str, draws: Draws) -> tuple[Rendered, ...]:
    """The recipes of drawn drifts, in one scene of a kind, or of each."""
    kinds = (checked_choice(kind, list(KINDS), "kind of scene"),) if kind else draws.kinds
    return tuple(
        Rendered(f"{kind}-{draws.seed}", draw, *draws.drift, kind, draws.frames)
        for kind in kinds
        for draw in range(draws.number)
    )
