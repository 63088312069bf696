"""Methods to judge: what each makes of recordings of one rig."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

import stereorecal as sr

_BOTH = ("extrinsics", "intrinsics")
_YAW = 1
_FAR = 30  # baselines


@dataclass(frozen=True, eq=False)
class Answer:
    """What a method found.

    Attributes:
        verdict: in a few words.
        rigs: "candidate" and, where it would be written, "accepted", or others by a name of theirs; empty if nothing
            came of it.
        yaw: None, or the candidate's yaw and the half width of its 95 % interval [degrees].
        depth: None, or the ends of the 95 % interval of the error of depth at 30 baselines that is stated [%] of the
            rig that the answer leaves in use.
        solution: that it is from, if it is one.
    """

    verdict: str
    rigs: Mapping[str, sr.StereoRig] = field(default_factory=dict)
    yaw: tuple[float, float] | None = None
    depth: tuple[float, float] | None = None
    solution: sr.Solution | None = None

    @property
    def accepted(self) -> sr.StereoRig | None:
        """The rig that would be written."""
        return self.rigs.get("accepted")

    @property
    def judged(self) -> dict[str, sr.StereoRig]:
        """The rigs, one that is accepted as it is only once."""
        same = "candidate" in self.rigs and self.accepted is not None and alike(self.rigs["candidate"], self.accepted)
        return {label: rig for label, rig in self.rigs.items() if not (same and label == "candidate")}


def alike(one: sr.StereoRig, other: sr.StereoRig) -> bool:
    """Whether two rigs are the same in every number."""

    def numbers(rig: sr.StereoRig) -> list[np.ndarray]:
        cameras = (rig.left, rig.right)
        return [np.asarray(rig.extrinsics), *(np.asarray(n) for c in cameras for n in (c.matrix, c.distortion))]

    return all(np.array_equal(a, b) for a, b in zip(numbers(one), numbers(other), strict=True))


def library(rig: sr.StereoRig, scenes: Sequence[sr.Scene]) -> Answer:
    """`sr.recalibrate` as it is called by default; of several scenes all pairs, as frames of one rig."""
    return _answer(sr.recalibrate(rig, [pair for scene in scenes for pair in scene.pairs]))


def library_free(rig: sr.StereoRig, scenes: Sequence[sr.Scene]) -> Answer:
    """The same with intrinsics freed."""
    return _answer(sr.recalibrate(rig, [pair for scene in scenes for pair in scene.pairs], free=_BOTH))


def _answer(solution: sr.Solution) -> Answer:
    rigs = {"candidate": solution.candidate} | ({"accepted": solution.rig} if solution.accepted else {})
    verdict, yaw, depth = solution.reason.name, None, None
    if solution.intrinsics is not None:
        verdict += f" / {solution.intrinsics.outcome.name}"
    known = solution.uncertainty
    if known is not None and "yaw" in known.names:
        half = float(known.interval[known.names.index("yaw")])
        yaw = float(np.degrees(solution.candidate.extrinsics[_YAW])), half
    if solution.expected is not None:
        stated = solution.expected.depth_percent[_FAR]
        depth = stated.low, stated.high
    return Answer(verdict, rigs, yaw, depth, solution)


METHODS = {"library": library, "library-free": library_free}
