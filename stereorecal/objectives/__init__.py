"""What strategies climb: scores of a stereo rig over the unit box."""

from stereorecal.objectives._chart import (
    FREE_AXES as FREE_AXES,
    Chart as Chart,
    Reach as Reach,
    chart_around as chart_around,
)
from stereorecal.objectives._count import objective as objective
from stereorecal.objectives._images import Images as Images
from stereorecal.objectives._rows import epipolar_objective as epipolar_objective
