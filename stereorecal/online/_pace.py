"""The speed at which a rig drifts, learnt while it drives.

Multiple-model estimation (Magill 1965): several filters differ only in how far the angles may move from one pair to the
next. A filter whose predictions fit the measurements gets more weight. Old measurements are forgotten.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.online._config import Config
from stereorecal.online._filter import FilterEstimate, Measurement

# Factors on `Config.wander` and `Config.heating`: calm, warm, hot; shaken.
_TIMES = np.array([(1.0, 0.25), (1.0, 1.0), (1.0, 4.0), (8.0, 1.0), (32.0, 1.0)])
_USUAL = np.log([0.3, 0.5, 0.1, 0.05, 0.05])
_MEMORY = 100.0  # measurements
_MOST = 25.0  # squared standard deviations of one measurement: outliers do not tell the speed


@dataclass(frozen=True, eq=False)
class Pace:
    """The filters and their evidence.

    Attributes:
        several: a filter for each pace.
        logs: (k,) logarithms of the evidence of each.
    """

    several: tuple[FilterEstimate, ...]
    logs: Float[np.ndarray, "k"]

    @staticmethod
    def at(estimate: FilterEstimate) -> "Pace":
        """Filters before anything is learnt."""
        return Pace((estimate,) * len(_TIMES), _USUAL)

    def again(self, estimate: FilterEstimate) -> "Pace":
        """The filters from another estimate on, with their evidence."""
        return replace(self, several=(estimate,) * len(self.several))

    def config(self, config: Config) -> Config:
        """The configuration with the learnt wander and heating."""
        weights = np.exp(self.logs - np.logaddexp.reduce(self.logs))
        return _scaled_rates(config, np.sqrt(weights @ _TIMES**2))

    def later(self, config: Config) -> "Pace":
        """The filters a frame later."""
        return replace(
            self,
            several=tuple(
                one.later(_scaled_rates(config, times)) for one, times in zip(self.several, _TIMES, strict=True)
            ),
        )

    def updated(self, measured: Measurement) -> "Pace":
        """The filters after one more measurement."""
        logs = np.array([one.log_likelihood(measured, _MOST) for one in self.several])
        logs = _USUAL + (1.0 - 1.0 / _MEMORY) * (self.logs - _USUAL) + logs
        return Pace(tuple(one.updated(one.doubted(measured)) for one in self.several), logs - logs.max())


def _scaled_rates(config: Config, times: Float[np.ndarray, "2"]) -> Config:
    wander, heating = (
        tuple((factor * np.asarray(some)).tolist())
        for factor, some in zip(times, (config.wander, config.heating), strict=True)
    )
    return replace(config, wander=wander, heating=heating)
