"""What the best, the median and the worst trial of a scene look like."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereorecal.comparison._summary import Thresholds, succeeded
from stereorecal.comparison._trial import Trial
from stereorecal.geometry import StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.recordings import Pair
from stereorecal.report.trial_picture import TrialPicture
from stereorecal.scoring.host import disparity


@dataclass(frozen=True, eq=False)
class Shown:
    """A scene's rig, the pair that is shown, and the matcher with its disparity range."""

    rig: StereoRig
    pair: Pair
    matcher: AbstractMatcher


def pictures_of(
    trials: Sequence[Trial], scenes: Mapping[str, Shown], thresholds: Thresholds
) -> tuple[TrialPicture, ...]:
    """Disparities before and after, of the best, the median and the worst trial of each scene (of one or two, where
    there are so few): those that succeeded first, as in the tables, and among them by r."""
    found = []
    for name, shown in scenes.items():
        finished = [trial for trial in trials if trial.scene == name and trial.ratio is not None and trial.extrinsics]
        ranked = sorted(finished, key=lambda trial: (not succeeded(trial, thresholds), -(trial.ratio or 0.0)))
        last = len(ranked) - 1
        places = {(last + 1) // 2: "median", last: "worst", 0: "best"} if ranked else {}  # of few, a later name holds
        for place, which in sorted(places.items()):
            found.append(_picture(which, ranked[place], shown, succeeded(ranked[place], thresholds)))
    return tuple(found)


def _picture(which: str, trial: Trial, scene: Shown, success: bool) -> TrialPicture:
    assert trial.extrinsics is not None
    rigs = [scene.rig.with_extrinsics(np.array(trial.extrinsics[when])) for when in ("start", "final")]
    before, after = (disparity(rig, scene.pair, matcher=scene.matcher) for rig in rigs)
    return TrialPicture(
        trial.scene,
        f"{which}: {trial.strategy}, schedule {trial.schedule}, draw {trial.draw}, r = {trial.ratio:.3f}, "
        f"{'a success' if success else 'no success'}",
        (np.asarray(before.values), np.asarray(before.valid)),
        (np.asarray(after.values), np.asarray(after.valid)),
    )
