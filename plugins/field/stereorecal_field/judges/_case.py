"""What methods are given, and who judges what they make of it."""

import abc
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import jax

from stereorecal.geometry import StereoRig
from stereorecal.recordings import Pair
from stereorecal.synthetic import decalibrate
from stereorecal_field.judges._judgement import Judgement

DEFAULT_PRIOR = "default"


@dataclass(frozen=True, eq=False)
class Case:
    """One calibration to correct, the same for every method.

    Attributes:
        start: the calibration that methods begin with.
        pairs: the images that they get; consecutive ones know their times.
        prior: what they are told of the intrinsics: that they are exact, or as a calibration leaves them.
        judge: of any rig of these cameras.
    """

    start: StereoRig
    pairs: tuple[Pair, ...]
    prior: str
    judge: Callable[[StereoRig], Judgement]


@dataclass(frozen=True)
class AbstractRecipe(abc.ABC):
    """A case that is not made yet: small, hashable, and the same case wherever it is made.

    Class attributes:
        judge: its kind.
        judged_by: what it judges by, for tables.

    Attributes:
        scene: its name in tables.
        draw: of the drift, or of what else is drawn; None: the calibration as it is stored.
        seed: of the draw.
        degrees, baseline_fraction: the largest drift of each angle, and of y and z.
    """

    judge: ClassVar[str]
    judged_by: ClassVar[str]

    scene: str
    draw: int | None
    seed: int
    degrees: float
    baseline_fraction: float

    @abc.abstractmethod
    def make(self) -> Case:
        """The case.

        Raises:
            InputError: if a folder does not hold what the judge needs.
        """

    def drifted(self, rig: StereoRig) -> StereoRig:
        """The rig after this draw's drift."""
        if self.draw is None:
            return rig
        key = jax.random.fold_in(jax.random.key(self.seed), self.draw)
        return decalibrate(rig, key, self.degrees, self.baseline_fraction)

    @property
    def key(self) -> str:
        """What tells it from all others of a table."""
        return f"{self.judge} | {self.scene} | {'stored' if self.draw is None else self.draw}"


@lru_cache(maxsize=2)
def case_of(recipe: AbstractRecipe) -> Case:
    """The case of a recipe; methods that follow each other share it."""
    return recipe.make()
