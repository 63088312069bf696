"""Global methods: they search the whole box, not only the neighbourhood of the start."""

from dataclasses import dataclass

import nlopt

from stereorecal.strategies import Budget
from stereorecal_nlopt._method import AbstractMethod
from stereorecal_nlopt._search import check_steps, over_the_box


@dataclass(frozen=True)
class AbstractGlobal(AbstractMethod):
    """A global method of NLopt; most have no stopping rule and use up the budget.

    Attributes:
        evaluations: without any budget the search ends after so many.
    """

    evaluations: int = 2000

    def __post_init__(self) -> None:
        if not self.evaluations > 0:
            raise ValueError(f"need evaluations > 0, got {self.evaluations}")

    def configure(self, opt: nlopt.opt, budget: Budget) -> None:
        """See `AbstractMethod.configure`."""
        if budget == Budget():
            opt.set_maxeval(self.evaluations)


@dataclass(frozen=True)
class Direct(AbstractGlobal):
    """DIRECT: divides the box where it is large or good (Jones, Perttunen & Stuckman 1993)."""

    algorithm = nlopt.GN_DIRECT


@dataclass(frozen=True)
class DirectL(AbstractGlobal):
    """DIRECT-L: DIRECT, biased towards the best part (Gablonsky & Kelley 2001)."""

    algorithm = nlopt.GN_DIRECT_L


@dataclass(frozen=True)
class DirectLRand(AbstractGlobal):
    """DIRECT-L with random choices between equal parts (Gablonsky & Kelley 2001, Johnson)."""

    algorithm = nlopt.GN_DIRECT_L_RAND


@dataclass(frozen=True)
class Ags(AbstractGlobal):
    """AGS: bounds the slope along a curve that fills a box of up to 5 dimensions (Strongin & Sergeyev 2000)."""

    max_dim = 5
    algorithm = nlopt.GN_AGS


@dataclass(frozen=True)
class AbstractPopulation(AbstractGlobal):
    """A global method that keeps a population.

    Attributes:
        evaluations: without any budget the search ends after so many.
        population: number of points in it; 0 for NLopt's own choice.
    """

    population: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.population >= 0:
            raise ValueError(f"need population >= 0, got {self.population}")

    def configure(self, opt: nlopt.opt, budget: Budget) -> None:
        """See `AbstractMethod.configure`."""
        super().configure(opt, budget)
        opt.set_population(self.population)


@dataclass(frozen=True)
class Crs2(AbstractPopulation):
    """CRS2: random simplices among a population that contracts (Price 1983, local mutation by Kaelo & Ali 2006).

    Attributes:
        evaluations: without any budget the search ends after about so many.
        population: number of points, at least n + 1; 0 for NLopt's choice, 10 (n + 1).
        xtol: the search ends when the best point moves by less; on a flat score it never does.
    """

    xtol: float = 1.0 / 128.0
    algorithm = nlopt.GN_CRS2_LM

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 <= self.xtol < 1.0:
            raise ValueError(f"need 0 <= xtol < 1, got {self.xtol}")

    def configure(self, opt: nlopt.opt, budget: Budget) -> None:
        """See `AbstractMethod.configure`."""
        super().configure(opt, budget)
        opt.set_xtol_abs(self.xtol)


@dataclass(frozen=True)
class Isres(AbstractPopulation):
    """ISRES: an evolution strategy with differential variation (Runarsson & Yao 2005).

    Attributes:
        evaluations: without any budget the search ends after so many.
        population: number of points; NLopt's choice (0), 20 (n + 1), is made for much larger budgets.
    """

    population: int = 20
    algorithm = nlopt.GN_ISRES


@dataclass(frozen=True)
class Esch(AbstractPopulation):
    """ESCH: an evolution strategy with Cauchy mutations (Santos, Goncalves & Hernandez-Figueroa 2010)."""

    algorithm = nlopt.GN_ESCH


@dataclass(frozen=True)
class Mlsl(AbstractPopulation):
    """MLSL: BOBYQA from many random starts, one for each basin as it hopes (Rinnooy Kan & Timmer 1987).

    Attributes:
        evaluations: without any budget the search ends after so many.
        population: random points between two rounds of local searches; 0 for NLopt's choice, 4.
        step: first step of a local search, in half widths of the search box.
        xtol: a local search ends when its steps are shorter.
    """

    step: float = 1.0 / 8.0
    xtol: float = 1.0 / 64.0
    algorithm = nlopt.G_MLSL

    def __post_init__(self) -> None:
        super().__post_init__()
        check_steps(self.step, self.xtol)

    def configure(self, opt: nlopt.opt, budget: Budget) -> None:
        """See `AbstractMethod.configure`."""
        super().configure(opt, budget)
        local = over_the_box(nlopt.LN_BOBYQA, opt.get_dimension())
        local.set_initial_step(self.step)
        local.set_xtol_abs(self.xtol)
        opt.set_local_optimizer(local)
