"""What lies inside of estimates, scores and matchers, and is held against a twin of its own.

What is private, tests import by this and `parts_of_repairs` alone.
"""

from stereorecal.decision._tolerances import COSTS as COSTS
from stereorecal.estimation import _calibration_prior as _calibration_prior
from stereorecal.estimation._calibration_prior import SIZES as SIZES, drift_sizes as drift_sizes, widest as widest
from stereorecal.estimation._estimate import parts_of as parts_of
from stereorecal.estimation._evidence import (
    Explanation as Explanation,
    Nuisances as Nuisances,
    all_explained as all_explained,
    marginal as marginal,
    normal_of as normal_of,
)
from stereorecal.estimation._groups import (
    FLOOR as FLOOR,
    Groups as Groups,
    first_of_same as first_of_same,
    grouped as grouped,
)
from stereorecal.estimation._linear_groups import (
    Model as Model,
    correlation as correlation,
    covariance_of_rows as covariance_of_rows,
    unexpected as unexpected,
)
from stereorecal.estimation._losses import (
    PointwiseLoss as PointwiseLoss,
    _normal as _normal,
    errors_near as errors_near,
    points_shown as points_shown,
)
from stereorecal.estimation._mixture import merged as merged
from stereorecal.estimation._motion_residuals import (
    Motion as Motion,
    by_theta as by_theta,
    residuals as residuals,
    track_readings as track_readings,
)
from stereorecal.estimation._outlines import (
    _rectangle as _rectangle,
    _squares as _squares,
    _sums as _sums,
    outlines as outlines,
)
from stereorecal.estimation._prior_choice import updated as updated
from stereorecal.estimation._rig_parameters import within_field as within_field
from stereorecal.matching.sad import _kernel as _kernel
from stereorecal.online._filter import (
    DRIFT as DRIFT,
    FilterEstimate as FilterEstimate,
    Measurement as Measurement,
    at_start as at_start,
)
from stereorecal.online._moving import small as small, turn as turn
from stereorecal.scoring._correspondences import _means_of_cells as _means_of_cells
from stereorecal.scoring._count import _soft_area as _soft_area
from stereorecal.scoring._rectify import Rectified as Rectified
from stereorecal.scoring._subpixel import refine as refine
from stereorecal.scoring.host import _survey as _survey
from stereorecal.scoring.host._disparities import counts_at_once as counts_at_once
from stereorecal.testing import _analytic_problems as _analytic_problems
