"""How the experiments count pixels: in one view and one disparity range for all calibrations that are compared."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereorecal.geometry import AXES, StereoRig, View, axis_errors, view, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.recalibration import Waypoint
from stereorecal.recordings import Log, Mission, Pair, PairSequence, names_of, picked
from stereorecal.scoring import host, prepare, select_frames
from stereorecal.scoring.host import with_disparity_range

_SURVEYED = 4  # pairs: as many as a survey looks at


@dataclass(frozen=True, eq=False)
class PixelCounter:
    """Counts the pixels with a valid disparity with fixed settings: one view, one disparity range.

    Attributes:
        rig: the manual calibration of the rig that took the images.
        matcher: with its disparity range.
        view: the rectified cameras.
        truth: the rig as it really was, where that is known.
    """

    rig: StereoRig
    matcher: AbstractMatcher
    view: View
    truth: StereoRig | None = None

    def counts(self, pair: Pair, extrinsics: Sequence[np.ndarray]) -> list[int]:
        """The count of a pair under each extrinsics (6,) [rad, m]."""
        candidates = np.stack([with_unit_baseline(one) for one in extrinsics])
        return host.counts(prepare(self.rig, [pair], self.view), candidates, self.matcher).tolist()

    def with_matcher(self, matcher: AbstractMatcher) -> "PixelCounter":
        """The same counter with another matcher, which gets the same disparity range."""
        mine = self.matcher
        ranged = replace(matcher, min_disparity=mine.min_disparity, num_disparities=mine.num_disparities)
        return replace(self, matcher=ranged)

    @property
    def reference(self) -> StereoRig:
        """The rig that errors refer to: the true one where it is known, else the manual calibration."""
        return self.truth or self.rig

    def errors(self, extrinsics: np.ndarray) -> tuple[dict[str, float], dict[str, float]]:
        """|pitch|, |yaw|, |roll| error [degrees] and |y|, |z| error [percent of the baseline]."""
        found = axis_errors(self.rig.with_extrinsics(extrinsics), self.reference)
        return {name: found[name] for name in AXES[:3]}, {name: found[name] for name in "yz"}

    def way(self, pair: Pair, path: Sequence[Waypoint]) -> list[dict[str, float]]:
        """The progress of a repair over its cost: the count, and the squared errors of rotation [degrees²] and of the
        direction of the translation [percent²]."""
        found = self.counts(pair, [point.extrinsics for point in path])
        rows = []
        for point, count in zip(path, found, strict=True):
            rotation, translation = self.errors(point.extrinsics)
            squared = [sum(error**2 for error in part.values()) for part in (rotation, translation)]
            rows.append({"cost": point.cost, "count": count, "rotation2": squared[0], "translation2": squared[1]})
        return rows


def counter_of(log: Log, mission: Mission, reach: Reach, matcher: AbstractMatcher) -> PixelCounter:
    """The pixel counter of a mission.

    The matcher's disparity range, if it has none, is measured with the manual calibration on the first pairs without a
    star, in the view of the ideal rig, which favours no calibration.
    """
    rig = log.calibration_of(mission)
    neutral = view(ideal(rig, float(rig.baseline)))
    pairs = select_frames(unstarred(mission), _SURVEYED)
    ranged = with_disparity_range(matcher, rig, pairs, neutral, np.radians(reach.degrees))
    return PixelCounter(rig, ranged, neutral, mission.truth)


def unstarred(mission: Mission) -> PairSequence:
    """The pairs without a star; all of them, if all are starred."""
    bright = [index for index, name in enumerate(names_of(mission.pairs)) if name not in mission.starred]
    return picked(mission.pairs, bright) if bright else mission.pairs


def ideal(rig: StereoRig, baseline: float) -> StereoRig:
    """The same cameras side by side: [0, 0, 0, -B, 0, 0]."""
    return rig.with_extrinsics(np.array([0.0, 0.0, 0.0, -baseline, 0.0, 0.0]))
