"""Global methods: they search the whole box, not just the neighbourhood of the start."""

from dataclasses import dataclass

import nlopt

from stereorecal.strategies import Budget, Objective
from stereorecal_nlopt._method import AbstractMethod
from stereorecal_nlopt._search import check_steps, over_the_box


@dataclass(frozen=True)
class AbstractGlobal(AbstractMethod):
    """A global method of NLopt; most have no stopping rule of their own and use up the budget.

    Attributes:
        evaluations: the search ends after this many if the budget has no limit.
    """

    evaluations: int = 2000

    def __post_init__(self) -> None:
        if not self.evaluations > 0:
            raise ValueError(f"need evaluations > 0, got {self.evaluations}")

    def configure(self, opt: nlopt.opt, objective: Objective) -> None:
        """See `AbstractMethod.configure`."""
        if objective.budget == Budget():  # no limit
            opt.set_maxeval(self.evaluations)


@dataclass(frozen=True)
class Direct(AbstractGlobal):
    """DIRECT: divides the box into rectangles, large and promising ones first (Jones et al. 1993)."""

    algorithm = nlopt.GN_DIRECT


@dataclass(frozen=True)
class DirectL(AbstractGlobal):
    """DIRECT-L: DIRECT, biased towards local search (Gablonsky & Kelley 2001)."""

    algorithm = nlopt.GN_DIRECT_L


@dataclass(frozen=True)
class DirectLRand(AbstractGlobal):
    """DIRECT-L with ties broken at random (Gablonsky & Kelley 2001, Johnson)."""

    algorithm = nlopt.GN_DIRECT_L_RAND


@dataclass(frozen=True)
class Ags(AbstractGlobal):
    """AGS: Lipschitz search along a space-filling curve, in up to 5 dimensions (Strongin & Sergeyev 2000)."""

    max_dim = 5
    algorithm = nlopt.GN_AGS


@dataclass(frozen=True)
class AbstractPopulation(AbstractGlobal):
    """A global method of NLopt with a population.

    Attributes:
        evaluations: the search ends after this many if the budget has no limit.
        population: number of points in it; 0 for NLopt's default.
    """

    population: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.population >= 0:
            raise ValueError(f"need population >= 0, got {self.population}")

    def configure(self, opt: nlopt.opt, objective: Objective) -> None:
        """See `AbstractMethod.configure`."""
        super().configure(opt, objective)
        opt.set_population(self.population)


@dataclass(frozen=True)
class Crs2(AbstractPopulation):
    """CRS2: controlled random search with local mutation (Price 1983, Kaelo & Ali 2006).

    Attributes:
        evaluations: the search ends after about this many if the budget has no limit.
        population: number of points, at least n + 1; 0 for NLopt's default, 10 (n + 1).
        xtol: the search ends when the best point moves by less than this, in half widths; never on a flat score.
    """

    xtol: float = 1.0 / 128.0
    algorithm = nlopt.GN_CRS2_LM

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 <= self.xtol < 1.0:
            raise ValueError(f"need 0 <= xtol < 1, got {self.xtol}")

    def configure(self, opt: nlopt.opt, objective: Objective) -> None:
        """See `AbstractMethod.configure`."""
        super().configure(opt, objective)
        opt.set_xtol_abs(self.xtol)


@dataclass(frozen=True)
class Isres(AbstractPopulation):
    """ISRES: an evolution strategy with stochastic ranking and differential variation (Runarsson & Yao 2005).

    Attributes:
        evaluations: the search ends after this many if the budget has no limit.
        population: number of points; NLopt's default (0), 20 (n + 1), suits much larger budgets.
    """

    population: int = 20
    algorithm = nlopt.GN_ISRES


@dataclass(frozen=True)
class Esch(AbstractPopulation):
    """ESCH: an evolution strategy with Cauchy mutations (Santos, Goncalves & Hernandez-Figueroa 2010)."""

    algorithm = nlopt.GN_ESCH


@dataclass(frozen=True)
class Mlsl(AbstractPopulation):
    """MLSL: multi-level single linkage, BOBYQA from clustered random starts (Rinnooy Kan & Timmer 1987).

    Attributes:
        evaluations: the search ends after this many if the budget has no limit.
        population: random points per round of local searches; 0 for NLopt's default, 4.
        step: first step of a local search, in half widths of the search box.
        xtol: a local search ends when its steps are shorter than this, in half widths.
    """

    step: float = 1.0 / 8.0
    xtol: float = 1.0 / 64.0
    algorithm = nlopt.G_MLSL

    def __post_init__(self) -> None:
        super().__post_init__()
        check_steps(self.step, self.xtol)

    def configure(self, opt: nlopt.opt, objective: Objective) -> None:
        """See `AbstractMethod.configure`."""
        super().configure(opt, objective)
        local = over_the_box(nlopt.LN_BOBYQA, opt.get_dimension())
        local.set_initial_step(self.step)
        local.set_xtol_abs(self.xtol)
        opt.set_local_optimizer(local)
