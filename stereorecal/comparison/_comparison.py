"""The result of a comparison, its JSON form (`stereorecal.compare/1`), and pictures of some trials."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stereorecal._arrays import json_data
from stereorecal._errors import extra
from stereorecal.comparison._profiles import Curve, curves
from stereorecal.comparison._summary import succeeded, summarise
from stereorecal.comparison._trial import THRESHOLDS, JudgedScene, Trial
from stereorecal.io import write_json, write_text
from stereorecal.report.disparity_map import TrialPicture
from stereorecal.scoring.host import disparity

SCHEMA = "stereorecal.compare/1"


@dataclass(frozen=True)
class Comparison:
    """A table of trials.

    Attributes:
        settings: the arguments, and who took part (`entrants`).
        versions: of Python, stereorecal, its dependencies and each strategy's distribution.
        scenes: name, size, frames, reference and disparity range of each scene.
        trials: the finished ones, in the order in which they were asked for.
        interrupted: True if some trials are missing.
        shown: what `to_html` makes pictures with, by scene.
    """

    settings: dict[str, Any]
    versions: dict[str, str]
    scenes: tuple[dict[str, Any], ...]
    trials: tuple[Trial, ...]
    interrupted: bool = False
    shown: Mapping[str, JudgedScene] = field(default_factory=dict, repr=False, compare=False)

    @property
    def summary(self) -> tuple[dict[str, Any], ...]:
        """Medians and success rates by scene, strategy, matcher and schedule."""
        return summarise(self.trials)

    def data_profile(self) -> tuple[Curve, ...]:
        """Curves of each scene, strategy and schedule, over units spent: the share of trials that are solved (a data
        profile, Moré & Wild 2009), and quartiles of the rotation error and of the best score."""
        return curves(self.trials)

    def as_dict(self) -> dict[str, Any]:
        """The content of the JSON file; a missing or non-finite number is None."""
        return json_data(
            {
                "schema": SCHEMA,
                "versions": self.versions,
                "settings": {**self.settings, "thresholds": THRESHOLDS},
                "interrupted": self.interrupted,
                "scenes": self.scenes,
                "trials": self.trials,
                "summary": self.summary,
            }
        )

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write the JSON file, whole or not at all."""
        write_json(path, self.as_dict())

    def to_html(self, path: str | os.PathLike[str], *, overwrite: bool = True) -> None:
        """Write one HTML page that needs nothing else, whole or not at all.

        Args:
            overwrite: whether an existing file may be replaced.

        Raises:
            InputError: if jinja2 or matplotlib is not installed, a file exists that must stay, or the place cannot be
                written to.
        """
        with extra("figures", "an HTML page"):
            from stereorecal.report.comparison_page import comparison_page
        profile = json_data(self.data_profile())
        pictures = pictures_of(self.trials, self.shown)
        write_text(path, comparison_page(self.as_dict(), profile, pictures), replace=overwrite)


def pictures_of(trials: Sequence[Trial], scenes: Mapping[str, JudgedScene]) -> tuple[TrialPicture, ...]:
    """Disparities before and after, of the best, the median and the worst trial of each scene (of one or two, where
    there are so few): those that succeeded first, as in the tables, and among them by r."""
    found = []
    for name, shown in scenes.items():
        finished = [trial for trial in trials if trial.scene == name and trial.ratio is not None and trial.extrinsics]
        ranked = sorted(finished, key=lambda trial: (not succeeded(trial), -(trial.ratio or 0.0)))
        last = len(ranked) - 1
        places = {(last + 1) // 2: "median", last: "worst", 0: "best"} if ranked else {}  # of few, a later name holds
        for place, which in sorted(places.items()):
            found.append(_picture(which, ranked[place], shown, succeeded(ranked[place])))
    return tuple(found)


def _picture(which: str, trial: Trial, judged: JudgedScene, success: bool) -> TrialPicture:
    assert trial.extrinsics is not None
    rigs = [judged.rig.with_extrinsics(np.array(trial.extrinsics[when])) for when in ("start", "final")]
    shown = (disparity(rig, judged.scene.pairs[0], matcher=judged.matcher) for rig in rigs)
    return TrialPicture(
        trial.scene,
        f"{which}: {trial.strategy}, schedule {trial.schedule}, draw {trial.draw}, r = {trial.ratio:.3f}, "
        f"{'a success' if success else 'no success'}",
        *((np.asarray(one.values), np.asarray(one.valid)) for one in shown),
    )
