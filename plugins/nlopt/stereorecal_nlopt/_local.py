"""Local derivative-free methods."""

from dataclasses import dataclass

import nlopt

from stereorecal.strategies import Objective
from stereorecal_nlopt._method import AbstractMethod
from stereorecal_nlopt._search import check_steps


@dataclass(frozen=True)
class AbstractLocal(AbstractMethod):
    """A local derivative-free method of NLopt.

    Attributes:
        step: first step, in half widths of the search box.
        xtol: the search ends when its steps are shorter than this, in half widths.
        ftol: it ends when the relative change of the score is below this. The default of 0 turns the test off, since a
            count has plateaus.
    """

    step: float = 1.0 / 8.0
    xtol: float = 1.0 / 128.0
    ftol: float = 0.0

    def __post_init__(self) -> None:
        check_steps(self.step, self.xtol, self.ftol)

    def configure(self, opt: nlopt.opt, objective: Objective) -> None:
        """See `AbstractMethod.configure`."""
        opt.set_initial_step(self.step)
        opt.set_xtol_abs(self.xtol)
        opt.set_ftol_rel(self.ftol)


@dataclass(frozen=True)
class Bobyqa(AbstractLocal):
    """BOBYQA: a trust region with a quadratic model through 2n + 1 points (Powell 2009)."""

    algorithm = nlopt.LN_BOBYQA


@dataclass(frozen=True)
class Cobyla(AbstractLocal):
    """COBYLA: a trust region with a linear model through n + 1 points (Powell 1994)."""

    algorithm = nlopt.LN_COBYLA


@dataclass(frozen=True)
class NewuoaBound(AbstractLocal):
    """NEWUOA with bounds: the predecessor of BOBYQA (Powell 2004, bounds by Johnson)."""

    algorithm = nlopt.LN_NEWUOA_BOUND
    min_dim = 2


@dataclass(frozen=True)
class NelderMead(AbstractLocal):
    """Nelder-Mead: the downhill simplex method (Nelder & Mead 1965, bounds after Box 1965)."""

    algorithm = nlopt.LN_NELDERMEAD


@dataclass(frozen=True)
class Sbplx(AbstractLocal):
    """Subplex: Nelder-Mead on a sequence of subspaces (Rowan 1990, reimplemented by Johnson)."""

    algorithm = nlopt.LN_SBPLX


@dataclass(frozen=True)
class Praxis(AbstractLocal):
    """PRAXIS: line searches along principal axes learned on the way, with random steps (Brent 1972).

    Attributes:
        step: first step, in half widths of the search box; PRAXIS raises it to at least 100 xtol.
        xtol: the search ends when its steps are shorter than this, in half widths. PRAXIS also uses it as the least
            step over which values differ: with a small one it gets stuck on the plateaus of a count.
        ftol: it ends when the relative change of the score is below this; 0 turns the test off.
    """

    xtol: float = 1.0 / 16.0
    algorithm = nlopt.LN_PRAXIS
    min_dim = 2
