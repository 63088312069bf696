"""How fast a rig drifts, learnt while it drives.

Several filters that differ in nothing but how far the angles may go from one pair to the next (multiple-model
estimation, Magill 1965): the one whose predictions the measurements fit best has most to say of how far they go. What
it was like long ago is forgotten.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.online._config import Config
from stereorecal.online._filter import FilterEstimate, Measurement

# Of `Config.wander`, and of `Config.heating`: calm, warm, hot; shaken.
_TIMES = np.array([(1.0, 0.25), (1.0, 1.0), (1.0, 4.0), (8.0, 1.0), (32.0, 1.0)])
_USUAL = np.log([0.3, 0.5, 0.1, 0.05, 0.05])
_MEMORY = 100.0  # measurements
_MOST = 25.0  # squared standard deviations of one: what is wrong says nothing of how fast anything is


@dataclass(frozen=True, eq=False)
class Pace:
    """The filters, and what each has to say.

    Attributes:
        several: one for each of the paces.
        logs: (k,) logarithms of the evidence of each.
    """

    several: tuple[FilterEstimate, ...]
    logs: Float[np.ndarray, "k"]

    @staticmethod
    def at(estimate: FilterEstimate) -> "Pace":
        """Nothing learnt yet."""
        return Pace((estimate,) * len(_TIMES), _USUAL)

    def again(self, estimate: FilterEstimate) -> "Pace":
        """From another estimate; how fast the rig drifts is as before."""
        return replace(self, several=(estimate,) * len(self.several))

    def config(self, config: Config) -> Config:
        """With the wander and the heating that were learnt."""
        weights = np.exp(self.logs - np.logaddexp.reduce(self.logs))
        return _scaled_rates(config, np.sqrt(weights @ _TIMES**2))

    def later(self, config: Config) -> "Pace":
        """A frame later."""
        return replace(
            self,
            several=tuple(
                one.later(_scaled_rates(config, times)) for one, times in zip(self.several, _TIMES, strict=True)
            ),
        )

    def updated(self, measured: Measurement) -> "Pace":
        """With one more measurement."""
        logs = np.array([one.log_likelihood(measured, _MOST) for one in self.several])
        logs = _USUAL + (1.0 - 1.0 / _MEMORY) * (self.logs - _USUAL) + logs
        return Pace(tuple(one.updated(one.doubted(measured)) for one in self.several), logs - logs.max())


def _scaled_rates(config: Config, times: Float[np.ndarray, "2"]) -> Config:
    wander, heating = (
        tuple((factor * np.asarray(some)).tolist())
        for factor, some in zip(times, (config.wander, config.heating), strict=True)
    )
    return replace(config, wander=wander, heating=heating)
