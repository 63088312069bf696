"""Gradient methods, on the soft count."""

from dataclasses import dataclass
from functools import lru_cache

import jax
import jax.numpy as jnp
import nlopt
import numpy as np
from jaxtyping import Float

from stereorecal.strategies import Need, Objective
from stereorecal_nlopt._method import AbstractMethod
from stereorecal_nlopt._search import Ask, Memory, check_steps


@jax.jit
def _value_and_gradient(score, z):
    # The score is a pytree that carries its data: as an argument, it lets all objectives of one shape share a program.
    return jax.value_and_grad(lambda point: score(point))(z)


def _gradients_of(objective: Objective, memory: Memory, step: float) -> Ask:
    """The soft count with its gradient, both scaled so that the first gradient has length `step`."""
    scale: float | None = None

    @lru_cache(maxsize=1)  # SLSQP asks for a value, then for the gradient at the same point
    def evaluated(point: bytes) -> tuple[float, Float[np.ndarray, "n"]]:
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
        value, slope = evaluated(z.tobytes())
        if scale is None:
            length = float(np.linalg.norm(slope))
            scale = step / length if length > 0.0 else 1.0
        if gradient.size:
            gradient[:] = scale * slope
        return scale * value

    return ask


@dataclass(frozen=True)
class AbstractGradient(AbstractMethod):
    """A local method of NLopt that uses the gradient of the soft count.

    The score is scaled so that its first gradient has length `step`: these methods have no option for the first step,
    and take the gradient itself as long as they have no estimate of the curvature.

    Attributes:
        step: first step, in half widths of the search box.
        xtol: the search ends when its steps are shorter than this, in half widths.
        ftol: it ends when the relative change of the score is below this; 0 turns the test off.
    """

    needs = Need.SMOOTH
    step: float = 1.0 / 8.0
    xtol: float = 1.0 / 1024.0
    ftol: float = 1e-5

    def __post_init__(self) -> None:
        check_steps(self.step, self.xtol, self.ftol)

    def configure(self, opt: nlopt.opt, objective: Objective) -> None:
        """See `AbstractMethod.configure`."""
        opt.set_xtol_abs(self.xtol)
        opt.set_ftol_rel(self.ftol)

    def asks(self, objective: Objective, memory: Memory) -> Ask:
        """The soft count with its gradient."""
        return _gradients_of(objective, memory, self.step)


@dataclass(frozen=True)
class Lbfgs(AbstractGradient):
    """L-BFGS: quasi-Newton steps from the last few gradients (Nocedal 1980, code by Luksan)."""

    algorithm = nlopt.LD_LBFGS


@dataclass(frozen=True)
class Slsqp(AbstractGradient):
    """SLSQP: sequential quadratic programming (Kraft 1988)."""

    algorithm = nlopt.LD_SLSQP


@dataclass(frozen=True)
class Ccsaq(AbstractGradient):
    """CCSAQ: conservative separable quadratic approximations (Svanberg 2002)."""

    algorithm = nlopt.LD_CCSAQ


@dataclass(frozen=True)
class Mma(AbstractGradient):
    """MMA: the method of moving asymptotes, globally convergent variant (Svanberg 2002)."""

    algorithm = nlopt.LD_MMA


@dataclass(frozen=True)
class TNewton(AbstractGradient):
    """Truncated Newton: preconditioned conjugate gradients with restarts (Dembo & Steihaug 1983, Luksan)."""

    algorithm = nlopt.LD_TNEWTON_PRECOND_RESTART


@dataclass(frozen=True)
class Var2(AbstractGradient):
    """VAR2: a limited-memory variable-metric method of rank 2 (Vlcek & Luksan 2006)."""

    algorithm = nlopt.LD_VAR2
