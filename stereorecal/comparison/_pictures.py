"""What the best, the median and the worst trial of a scene look like."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereorecal.comparison._trial import Trial
from stereorecal.geometry import StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.recordings import Pair
from stereorecal.report.comparison import TrialPicture
from stereorecal.scoring.host import disparity


@dataclass(frozen=True, eq=False)
class Shown:
    """A scene's rig, the pair that is shown, and the matcher with its disparity range."""

    rig: StereoRig
    pair: Pair
    matcher: AbstractMatcher


def pictures_of(trials: Sequence[Trial], scenes: Mapping[str, Shown]) -> tuple[TrialPicture, ...]:
    """Disparities before and after, of three trials of each scene by their ratio (of one or two, where there are so
    few)."""
    found = []
    for name, shown in scenes.items():
        finished = [trial for trial in trials if trial.scene == name and trial.ratio is not None and trial.extrinsics]
        ranked = sorted(finished, key=lambda trial: -(trial.ratio or 0.0))
        places = {"best": 0, "median": len(ranked) // 2, "worst": len(ranked) - 1}
        names = {place: which for which, place in reversed(places.items()) if ranked}  # the first name of each
        for place, which in sorted(names.items()):
            found.append(_picture(which, ranked[place], shown))
    return tuple(found)


def _picture(which: str, trial: Trial, shown: Shown) -> TrialPicture:
    assert trial.extrinsics is not None
    rigs = [shown.rig.with_extrinsics(np.array(trial.extrinsics[when])) for when in ("start", "final")]
    before, after = (disparity(rig, shown.pair, matcher=shown.matcher) for rig in rigs)
    return TrialPicture(
        trial.scene,
        f"{which}: {trial.strategy}, schedule {trial.schedule}, draw {trial.draw}, r = {trial.ratio:.3f}",
        (np.asarray(before.values), np.asarray(before.valid)),
        (np.asarray(after.values), np.asarray(after.valid)),
    )
