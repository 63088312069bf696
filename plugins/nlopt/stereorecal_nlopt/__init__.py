"""NLopt's optimisers as stereorecal strategies: local and global ones on counts, gradient methods on the soft count.

Each is a strategy of its own (`nlopt-bobyqa`, …). All of NLopt's derivative-free methods that differ on a box are here,
except the original DIRECT, which kills the process when it is stopped, and MLSL with quasi-random points. NLopt is by
Steven G. Johnson, https://github.com/stevengj/nlopt.
"""

from stereorecal_nlopt._global import (
    Ags as Ags,
    Crs2 as Crs2,
    Direct as Direct,
    DirectL as DirectL,
    DirectLRand as DirectLRand,
    Esch as Esch,
    Isres as Isres,
    Mlsl as Mlsl,
)
from stereorecal_nlopt._gradient import (
    Ccsaq as Ccsaq,
    Lbfgs as Lbfgs,
    Mma as Mma,
    Slsqp as Slsqp,
    TNewton as TNewton,
    Var2 as Var2,
)
from stereorecal_nlopt._local import (
    Bobyqa as Bobyqa,
    Cobyla as Cobyla,
    NelderMead as NelderMead,
    NewuoaBound as NewuoaBound,
    Praxis as Praxis,
    Sbplx as Sbplx,
)
