"""What strategies climb: scores of a stereo rig over the unit box.

`_search_box` says which extrinsics are free and how far they may be off, `_chart` maps the box to extrinsics, and each
score has a module: `_count` the paper's count, `_rows` epipolar residuals.
"""

from stereorecal.objectives._chart import Chart as Chart
from stereorecal.objectives._count import count_objective as count_objective, objective as objective
from stereorecal.objectives._images import Images as Images
from stereorecal.objectives._linearised import (
    LinearRows as LinearRows,
    differences_at as differences_at,
    linearised as linearised,
)
from stereorecal.objectives._rows import epipolar_objective as epipolar_objective
from stereorecal.objectives._search_box import (
    FREE_AXES as FREE_AXES,
    Reach as Reach,
    SearchBox as SearchBox,
    as_reach as as_reach,
    count_box as count_box,
    row_box as row_box,
)
