"""The result of a comparison and its JSON form (`stereorecal.compare/1`)."""

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from stereorecal._arrays import json_data
from stereorecal._errors import extra
from stereorecal.comparison._profiles import Curve, curves
from stereorecal.comparison._summary import Summary, Thresholds, summarise
from stereorecal.comparison._trial import Trial
from stereorecal.comparison._trial_pictures import Shown, pictures_of
from stereorecal.io import write_json, write_text

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
    thresholds: Thresholds = field(default_factory=Thresholds)
    interrupted: bool = False
    shown: Mapping[str, Shown] = field(default_factory=dict, repr=False, compare=False)

    @property
    def summary(self) -> tuple[Summary, ...]:
        """Medians and success rates by scene, strategy, matcher and schedule."""
        return summarise(self.trials, self.thresholds)

    def data_profile(self) -> tuple[Curve, ...]:
        """For each scene, strategy and schedule, over units spent: the share of the trials that are solved (a data
        profile, Moré & Wild 2009), and quartiles of the rotation error and of the best score."""
        return curves(self.trials, self.thresholds)

    def as_dict(self) -> dict[str, Any]:
        """The content of the JSON file; a missing or non-finite number is None."""
        return json_data(
            {
                "schema": SCHEMA,
                "versions": self.versions,
                "settings": {**self.settings, "thresholds": asdict(self.thresholds)},
                "interrupted": self.interrupted,
                "scenes": list(self.scenes),
                "trials": [asdict(trial) for trial in self.trials],
                "summary": [asdict(summary) for summary in self.summary],
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
        profile = [json_data(asdict(curve)) for curve in self.data_profile()]
        pictures = pictures_of(self.trials, self.shown, self.thresholds)
        write_text(path, comparison_page(self.as_dict(), profile, pictures), replace=overwrite)
