"""One search of NLopt over the unit box: evaluations, points without a value, exceptions and how it ends."""

import contextlib
import weakref
from collections.abc import Callable
from dataclasses import dataclass

import nlopt
import numpy as np
from jaxtyping import Float

from stereorecal.strategies import Objective, Outcome, Status

# (point, gradient to fill in, or an empty array) -> value; NLopt accepts nothing but a Python float.
Ask = Callable[[Float[np.ndarray, "n"], Float[np.ndarray, "m"]], float]

_UNKNOWN = -1e9  # stands in as long as the score has had no value anywhere: far below any score, and finite
_ENDS = {
    nlopt.SUCCESS: (Status.CONVERGED, "the method met its own stopping rule"),
    nlopt.STOPVAL_REACHED: (Status.CONVERGED, "the score has reached its upper limit"),
    nlopt.FTOL_REACHED: (Status.CONVERGED, "the score changes by less than ftol"),
    nlopt.XTOL_REACHED: (Status.CONVERGED, "the steps are shorter than xtol"),
    nlopt.MAXEVAL_REACHED: (Status.CONVERGED, "the option `evaluations` ends a search whose budget has no limit"),
    nlopt.ROUNDOFF_LIMITED: (Status.CONVERGED, "rounding errors prevent further progress"),
}


@dataclass
class Memory:
    """The best point so far, and a substitute for the score where it has no value.

    NLopt's methods do not cope with NaN or infinity; AGS even crashes the process. The substitute lies below all values
    so far and leads back to the best point, which also suits methods that build a model of the score.
    """

    best: Float[np.ndarray, "n"]
    highest: float = -np.inf
    lowest: float = np.inf

    def keep(self, z: Float[np.ndarray, "n"], value: float) -> None:
        """Remember the finite value at z."""
        if value > self.highest:
            self.best, self.highest = z.copy(), value
        self.lowest = min(self.lowest, value)

    def stand_in(self, z: Float[np.ndarray, "n"]) -> tuple[float, Float[np.ndarray, "n"]]:
        """A value for z below all values so far, and a gradient that points back to the best point."""
        if np.isinf(self.highest):
            return _UNKNOWN, np.zeros_like(z)
        drop = max(2.0 * (self.highest - self.lowest), abs(self.highest)) or 1.0
        offset = z - self.best
        return self.highest - drop, -2.0 * drop * offset / max(offset @ offset, 1e-12)


def values_of(objective: Objective, memory: Memory) -> Ask:
    """The scores on the host."""

    def ask(z: Float[np.ndarray, "n"], gradient: Float[np.ndarray, "m"]) -> float:
        value = objective.value(z)
        if not np.isfinite(value):
            return memory.stand_in(z)[0]
        memory.keep(z, value)
        return value

    return ask


def check_steps(step: float, xtol: float, ftol: float = 0.0) -> None:
    """Raises ValueError unless 0 < xtol <= step <= 2, the width of the box, and 0 <= ftol < 1."""
    if not 0.0 < xtol <= step <= 2.0:
        raise ValueError(f"need 0 < xtol <= step <= 2, got {xtol} and {step}")
    if not 0.0 <= ftol < 1.0:
        raise ValueError(f"need 0 <= ftol < 1, got {ftol}")


def over_the_box(algorithm: int, dim: int) -> nlopt.opt:
    """NLopt's optimiser, bounded by the unit box."""
    opt = nlopt.opt(algorithm, dim)
    opt.set_lower_bounds(-1.0)
    opt.set_upper_bounds(1.0)
    return opt


def search(opt: nlopt.opt, ask: Ask, memory: Memory, seed: int) -> Outcome:
    """Maximise, starting from `memory.best`. An exception raised by `ask` ends the search and is raised here.

    NLopt's random generator is global, one for each thread; it is seeded here.
    """
    crash: BaseException | None = None
    # `opt` owns `guarded` where Python's garbage collector cannot see it: a strong reference back would leak.
    stop = weakref.proxy(opt)

    def guarded(z: Float[np.ndarray, "n"], gradient: Float[np.ndarray, "m"]) -> float:
        # After an exception or a stop, some methods go on evaluating, or take the point where it happened for the best.
        nonlocal crash
        try:
            if crash is None:
                return ask(np.clip(z, -1.0, 1.0), gradient)  # NLopt keeps the bounds up to rounding only
        except BaseException as error:
            crash = error
            stop.force_stop()
        gradient[:] = 0.0
        return _UNKNOWN

    nlopt.srand(seed % 2**32)
    opt.set_max_objective(guarded)
    with contextlib.suppress(nlopt.exception, nlopt.ForcedStop, nlopt.RoundoffLimited):  # the result code says which
        opt.optimize(np.clip(memory.best, -1.0, 1.0))
    if crash is not None:
        try:
            raise crash
        finally:
            del crash  # its traceback refers to `opt`: a cycle again
    result = opt.last_optimize_result()
    if result == nlopt.INVALID_ARGS:
        raise ValueError(f"NLopt refuses the options: {opt.get_errmsg() or 'no reason given'}")
    if np.isinf(memory.highest):
        return Outcome(memory.best, Status.STALLED, "the score has no value at any point that was tried")
    status, message = _ENDS.get(result, (Status.STALLED, f"NLopt gave up: {opt.get_errmsg() or 'no reason given'}"))
    return Outcome(memory.best, status, message)
