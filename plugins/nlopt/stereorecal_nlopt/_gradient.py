"""Gradient methods, on the soft count."""

from dataclasses import dataclass
from functools import lru_cache

import jax
import jax.numpy as jnp
import nlopt
import numpy as np
from jaxtyping import Float

from stereorecal.strategies import Budget, Need, Objective
from stereorecal_nlopt._method import AbstractMethod
from stereorecal_nlopt._search import Ask, Memory, check_steps


@jax.jit
def _value_and_gradient(score, z):
    # The score is an argument, a pytree with its data: all methods, and all objectives of one shape, share one program.
    return jax.value_and_grad(lambda point: score(point))(z)


def _gradients_of(objective: Objective, memory: Memory, step: float) -> Ask:
    """Ask for soft counts with their gradients, scaled so that the first gradient is `step` long."""
    scale: float | None = None

    @lru_cache(maxsize=1)  # SLSQP may ask for the value, and then for the gradient at the same point
    def told(point: bytes) -> tuple[float, Float[np.ndarray, "n"]]:
        z = np.frombuffer(point)
        objective.reserve(objective.gradient_cost)
        score, slope = _value_and_gradient(objective.traced.soft_count, jnp.asarray(z, jnp.float32))
        value, gradient = float(score), np.asarray(slope, float)
        known = np.isfinite(value) and np.isfinite(gradient).all()
        if known:
            memory.keep(z, value)
        objective.charge(objective.gradient_cost, memory.best)
        return (value, gradient) if known else memory.stand_in(z)

    def ask(z: Float[np.ndarray, "n"], gradient: Float[np.ndarray, "m"]) -> float:
        nonlocal scale
        value, slope = told(z.tobytes())
        if scale is None:
            length = float(np.linalg.norm(slope))
            scale = step / length if length > 0.0 else 1.0
        if gradient.size:
            gradient[:] = scale * slope
        return scale * value

    return ask


@dataclass(frozen=True)
class AbstractGradient(AbstractMethod):
    """A local method of NLopt that follows the gradient of the soft count.

    The score is scaled so that its first gradient is `step` long: these methods have no option for it, and as long as
    they know nothing of the curvature they step by the gradient.

    Attributes:
        step: first step, in half widths of the search box.
        xtol: the search ends when its steps are shorter.
        ftol: it ends when the score changes by a smaller share of itself; 0 for never.
    """

    needs = Need.SMOOTH
    step: float = 1.0 / 8.0
    xtol: float = 1.0 / 1024.0
    ftol: float = 1e-5

    def __post_init__(self) -> None:
        check_steps(self.step, self.xtol, self.ftol)

    def configure(self, opt: nlopt.opt, budget: Budget) -> None:
        """See `AbstractMethod.configure`."""
        opt.set_xtol_abs(self.xtol)
        opt.set_ftol_rel(self.ftol)

    def asks(self, objective: Objective, memory: Memory) -> Ask:
        """Soft counts with their gradients."""
        return _gradients_of(objective, memory, self.step)


@dataclass(frozen=True)
class Lbfgs(AbstractGradient):
    """L-BFGS: quasi-Newton steps that remember few gradients (Nocedal 1980, code by Luksan)."""

    algorithm = nlopt.LD_LBFGS


@dataclass(frozen=True)
class Slsqp(AbstractGradient):
    """SLSQP: a quadratic programme at each step (Kraft 1988)."""

    algorithm = nlopt.LD_SLSQP


@dataclass(frozen=True)
class Ccsaq(AbstractGradient):
    """CCSAQ: separable quadratic models that are surely too low (Svanberg 2002)."""

    algorithm = nlopt.LD_CCSAQ


@dataclass(frozen=True)
class Mma(AbstractGradient):
    """MMA: moving asymptotes, the variant that converges from anywhere (Svanberg 2002)."""

    algorithm = nlopt.LD_MMA


@dataclass(frozen=True)
class TNewton(AbstractGradient):
    """Truncated Newton: conjugate gradients inside, preconditioned, with restarts (Dembo & Steihaug 1983, Luksan)."""

    algorithm = nlopt.LD_TNEWTON_PRECOND_RESTART


@dataclass(frozen=True)
class Var2(AbstractGradient):
    """VAR2: the rank-2 variable metric method with limited memory (Vlcek & Luksan 2006)."""

    algorithm = nlopt.LD_VAR2
