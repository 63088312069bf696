"""The objectives of strategies: scores of a stereo rig over the unit box, and the charts of that."""

from stereorecal.objectives._charts import (
    RigChart as RigChart,
    count_chart as count_chart,
    row_chart as row_chart,
)
from stereorecal.objectives._count_objective import (
    StereoImages as StereoImages,
    count_objective as count_objective,
    objective as objective,
)
from stereorecal.objectives._linear_rows import (
    differences_at as differences_at,
    epipolar_objective as epipolar_objective,
    linear_residuals as linear_residuals,
    linearised as linearised,
    rectified_at as rectified_at,
)
from stereorecal.objectives._parameters import (
    BASELINE as BASELINE,
    EXTRINSICS as EXTRINSICS,
    ROTATION as ROTATION,
    SIDES as SIDES,
    Parameter as Parameter,
    Parameters as Parameters,
    Reach as Reach,
    as_parameters as as_parameters,
    as_reach as as_reach,
)
