"""Optimistix's solvers as stereorecal strategies.

A solver never calls the objective itself: each step is given the value and the derivative at the point that the step
before it asked for (`_step`). So the objective is compiled once for all solvers, a solver once for all objectives, and
between two steps the host can count, stop and record.

The strategies are declarations: equinox, optimistix and optax are imported by the first run (`_importing`).
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
