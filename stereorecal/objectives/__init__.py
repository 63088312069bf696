"""The objectives of strategies: scores of a stereo rig over the unit box.

`_parameters` holds the free parameters and their priors, `_chart` and `_rig_chart` map the box to extrinsics and to
whole rigs, and each score has a module: `_count_objective` and `_epipolar_objective`.
"""

from stereorecal.objectives._chart import Chart as Chart
from stereorecal.objectives._count_objective import (
    count_objective as count_objective,
    objective as objective,
    rig_count_objective as rig_count_objective,
)
from stereorecal.objectives._epipolar_objective import (
    epipolar_objective as epipolar_objective,
    linear_residuals as linear_residuals,
)
from stereorecal.objectives._linear_rows import (
    LinearRows as LinearRows,
    differences_at as differences_at,
    linearised as linearised,
)
from stereorecal.objectives._parameter_names import (
    BASELINE as BASELINE,
    EXTRINSICS as EXTRINSICS,
    ROTATION as ROTATION,
    SIDES as SIDES,
)
from stereorecal.objectives._parameters import (
    Parameter as Parameter,
    Parameters as Parameters,
    as_parameters as as_parameters,
)
from stereorecal.objectives._reach import (
    Reach as Reach,
    as_reach as as_reach,
    count_chart as count_chart,
)
from stereorecal.objectives._rig_chart import (
    RigChart as RigChart,
    reach_chart as reach_chart,
    row_chart as row_chart,
)
from stereorecal.objectives._stereo_images import StereoImages as StereoImages
