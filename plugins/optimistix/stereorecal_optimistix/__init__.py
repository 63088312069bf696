"""Optimistix's solvers as stereorecal strategies.

A solver never calls the objective. Each step is given the answer to the question that the step before it left open
(`_step`): where to look, what was seen there. So the objective is compiled once for all solvers, the solvers once for
all objectives, and between two steps the host can count, stop and remember.
"""

from stereorecal_optimistix._least_squares import (
    Dogleg as Dogleg,
    GaussNewton as GaussNewton,
    LevenbergMarquardt as LevenbergMarquardt,
)
from stereorecal_optimistix._minimise import (
    BFGS as BFGS,
    LBFGS as LBFGS,
    Adam as Adam,
    GradientDescent as GradientDescent,
    NonlinearCG as NonlinearCG,
)
from stereorecal_optimistix._nelder_mead import NelderMead as NelderMead
