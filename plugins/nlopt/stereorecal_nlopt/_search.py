"""One search of NLopt over the unit box: what it asks, what it is told, and how it ends."""

import contextlib
import weakref
from collections.abc import Callable
from dataclasses import dataclass

import nlopt
import numpy as np
from jaxtyping import Float

from stereorecal.strategies import Objective, Outcome, Status

# (point, gradient to fill in, or empty) -> value, a Python float: NLopt takes nothing else.
Ask = Callable[[Float[np.ndarray, "n"], Float[np.ndarray, "m"]], float]

_UNKNOWN = -1e9  # told for a score that has had no value anywhere yet
_ENDS = {
    nlopt.SUCCESS: (Status.CONVERGED, "the method met its own stopping rule"),
    nlopt.STOPVAL_REACHED: (Status.CONVERGED, "the score cannot rise any further"),
    nlopt.FTOL_REACHED: (Status.CONVERGED, "the score changes by less than ftol"),
    nlopt.XTOL_REACHED: (Status.CONVERGED, "the steps are shorter than xtol"),
    nlopt.MAXEVAL_REACHED: (Status.CONVERGED, "without a budget it ends after its own number of evaluations"),
    nlopt.ROUNDOFF_LIMITED: (Status.CONVERGED, "rounding stands in the way of a further step"),
}


@dataclass
class Memory:
    """The best point so far, and what stands in for the score where it has no value.

    NLopt's methods do not cope with NaN or infinity, and AGS kills the process. The stand-in is a bowl around the best
    point that passes below all values so far: methods that build a model of the score can live with it.
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
        """A value for z below all so far, and the gradient of the bowl there."""
        if np.isinf(self.highest):
            return _UNKNOWN, np.zeros_like(z)
        drop = max(2.0 * (self.highest - self.lowest), abs(self.highest)) or 1.0
        offset = z - self.best
        return self.highest - drop, -2.0 * drop * offset / max(offset @ offset, 1e-12)


def values_of(objective: Objective, memory: Memory) -> Ask:
    """Ask for the scores on the host."""

    def ask(z: Float[np.ndarray, "n"], gradient: Float[np.ndarray, "m"]) -> float:
        value = objective.value(z)
        if not np.isfinite(value):
            return memory.stand_in(z)[0]
        memory.keep(z, value)
        return value

    return ask


def check_steps(step: float, xtol: float, ftol: float = 0.0) -> None:
    """Raises ValueError unless steps of these lengths, in half widths of the box, make sense."""
    if not 0.0 < xtol <= step <= 2.0:
        raise ValueError(f"need 0 < xtol <= step <= 2, got {xtol} and {step}")
    if not 0.0 <= ftol < 1.0:
        raise ValueError(f"need 0 <= ftol < 1, got {ftol}")


def over_the_box(algorithm: int, dim: int) -> nlopt.opt:
    """An optimiser of NLopt over the unit box."""
    opt = nlopt.opt(algorithm, dim)
    opt.set_lower_bounds(-1.0)
    opt.set_upper_bounds(1.0)
    return opt


def search(opt: nlopt.opt, ask: Ask, memory: Memory, seed: int) -> Outcome:
    """Maximise from `memory.best`; an exception of `ask` ends the search and passes.

    NLopt's random numbers are global state, one for each thread: this seeds it.
    """
    crash: BaseException | None = None
    # `opt` owns `guarded`, out of sight of Python's garbage collector: a reference back would be a leak.
    stop = weakref.proxy(opt)

    def guarded(z: Float[np.ndarray, "n"], gradient: Float[np.ndarray, "m"]) -> float:
        # Some methods go on asking after an exception or a stop, or take the exception's place for the best value.
        nonlocal crash
        try:
            if crash is None:
                return ask(np.clip(z, -1.0, 1.0), gradient)  # the bounds are kept up to rounding
        except BaseException as error:
            crash = error
            stop.force_stop()
        gradient[:] = 0.0
        return _UNKNOWN

    nlopt.srand(seed % 2**32)
    opt.set_max_objective(guarded)
    with contextlib.suppress(nlopt.exception, nlopt.ForcedStop, nlopt.RoundoffLimited):  # the result says which
        opt.optimize(np.clip(memory.best, -1.0, 1.0))
    if crash is not None:
        try:
            raise crash
        finally:
            del crash  # its traceback leads to `opt`: the cycle again
    result = opt.last_optimize_result()
    if result == nlopt.INVALID_ARGS:
        raise ValueError(f"NLopt refuses the options: {opt.get_errmsg() or 'it does not say why'}")
    if np.isinf(memory.highest):
        return Outcome(memory.best, Status.STALLED, "the score has no value at any point that was tried")
    status, message = _ENDS.get(result, (Status.STALLED, f"NLopt gave up: {opt.get_errmsg() or 'no reason given'}"))
    return Outcome(memory.best, status, message)
