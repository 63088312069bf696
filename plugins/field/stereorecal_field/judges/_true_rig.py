"""A judge that knows the true rig."""

from dataclasses import dataclass

from stereorecal.comparison import DISTANCES
from stereorecal.geometry import AXES, StereoRig, View, axis_errors
from stereorecal.recalibration import difference
from stereorecal_field.judges._judgement import Judgement


@dataclass(frozen=True, eq=False)
class ByTrueRig:
    """Rows and depth of points whose pixels the true rig tells, and the errors of the angles.

    Attributes:
        view: in which rows are compared.
    """

    truth: StereoRig
    view: View

    def __call__(self, rig: StereoRig) -> Judgement:
        wrong = difference(rig, self.truth, view=self.view)
        errors = axis_errors(rig, self.truth)
        return Judgement(
            wrong.row_error_median,
            {distance: wrong.depth_error_percent[distance] for distance in DISTANCES},
            {name: errors[name] for name in AXES[:3]},
        )
