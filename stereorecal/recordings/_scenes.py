"""What a rig took: a scene at one place; a log of missions over the years, and the calibrations made of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.recordings._as_pairs import check_pairs
from stereorecal.recordings._lazy_pairs import LazyPairs, PairSequence, names_of
from stereorecal.recordings._pair import Pair


@dataclass(frozen=True, eq=False)
class Scene:
    """A rig (None without calibration) and the pairs it took.

    Attributes:
        reference: what `rig` is worth as a reference: "truth" (synthetic) or "stored" (a calibration from a file).
        info: other facts about the scene, carried along untouched.
    """

    name: str
    rig: StereoRig | None
    pairs: tuple[Pair, ...]
    reference: str = "stored"
    info: Mapping[str, Any] = field(default_factory=dict, repr=False)


@dataclass(frozen=True, eq=False)
class Mission:
    """One sequence of pairs, over which the rig did not change.

    Attributes:
        name: of the sequence.
        calibration: name of the manual calibration that holds for it.
        pairs: in the order in which they were taken; their names are unique within the mission. Those that `load_log`
            finds are read each time they are used: iterate over them, and keep the ones you need.
        starred: names of pairs with little to match, such as those of the open sea.
        truth: the rig as it really was, where that is known.
    """

    name: str
    calibration: str
    pairs: PairSequence
    starred: frozenset[str] = frozenset()
    truth: StereoRig | None = None


@dataclass(frozen=True, eq=False)
class Log:
    """Missions, and the calibrations that hold for them; mostly those of one rig over the years.

    Attributes:
        name: what people call it.
        calibrations: by name, in the order in which they were made.
        missions: at least one, each with a name of its own.

    Raises:
        InputError: if there is no mission, two missions or two pairs of one have the same name, a calibration is not
            there, or images do not fit it. Of pairs that are not read yet, the first of each mission is checked.
    """

    name: str
    calibrations: Mapping[str, StereoRig] = field(repr=False)
    missions: tuple[Mission, ...] = field(repr=False)

    def __post_init__(self) -> None:
        if not self.missions:
            raise InputError(f"{self.name}: the log has no sequence; add one.")
        if len({mission.name for mission in self.missions}) < len(self.missions):
            raise InputError(f"{self.name}: two sequences have the same name; rename one.")
        for mission in self.missions:
            if len(set(names_of(mission.pairs))) < len(mission.pairs):
                raise InputError(f"{mission.name}: two pairs have the same name; rename one.")
            if mission.calibration not in self.calibrations:
                raise InputError(f"{mission.name}: there is no calibration {mission.calibration!r} in the log; add it.")
            lazy = isinstance(mission.pairs, LazyPairs)
            check_pairs(self.calibration_of(mission), tuple(mission.pairs[:1]) if lazy else mission.pairs)

    def calibration_of(self, mission: Mission) -> StereoRig:
        """The manual calibration that holds for a mission."""
        return self.calibrations[mission.calibration]

    def scene(self, mission: Mission) -> Scene:
        """A mission as a scene with its manual calibration; its pairs are read."""
        return Scene(mission.name, self.calibration_of(mission), tuple(mission.pairs))
