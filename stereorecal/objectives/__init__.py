"""What strategies climb: scores of a stereo rig over the unit box.

`_parameters` says what is free and how far it may be off, `_chart` and `_rig_chart` map the box to extrinsics and to
whole rigs, and each score has a module: `_count` the paper's count, `_rows` epipolar residuals.
"""

from stereorecal.objectives._chart import Chart as Chart
from stereorecal.objectives._count import (
    count_objective as count_objective,
    objective as objective,
    rig_count_objective as rig_count_objective,
)
from stereorecal.objectives._images import Images as Images
from stereorecal.objectives._linearised import (
    LinearRows as LinearRows,
    differences_at as differences_at,
    linearised as linearised,
    read_by as read_by,
)
from stereorecal.objectives._names import (
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
from stereorecal.objectives._rows import epipolar_objective as epipolar_objective
