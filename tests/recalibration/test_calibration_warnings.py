"""Values of a calibration that hardly any rig has are named."""

import numpy as np
import pytest

from stereorecal import InputError, StereoRig, view
from stereorecal.geometry import Camera
from stereorecal.recalibration._calibration_warnings import doubts


def rig_of(model: str, coefficients) -> StereoRig:
    matrix = np.array([[300.0, 0.0, 320.0], [0.0, 300.0, 240.0], [0.0, 0.0, 1.0]])
    camera = Camera((640, 480), matrix, np.array(coefficients), model=model)
    return StereoRig(camera, camera, np.array([0.0, 0.0, 0.0, -0.1, 0.0, 0.0]))


@pytest.mark.parametrize(
    ("model", "coefficients", "said"),
    [
        ("equidistant", (-5.0, 0.0, 0.0, 0.0), "fold the image back 15 degrees"),
        ("omni", (1.5, -3.0, 0.0, 0.0, 0.0), "fold the image back"),
        ("ds", (-0.99, 0.6), "is a view of 1 degrees"),
        ("equidistant", (-0.2, 0.0, 0.0, 0.0), None),
        ("equidistant", (0.1, -0.2, 0.1, 0.0), None),
        ("ds", (-0.2, 0.6), None),
    ],
)
def test_wide_lenses_that_no_camera_has_are_named(model, coefficients, said):
    found = doubts(rig_of(model, coefficients))
    assert (said is None) == (not found)
    assert all(said in one for one in found)


def test_a_lens_without_resolution_has_no_view():
    with pytest.raises(InputError, match=r"5\.88 px per radian in images 640 px wide"):
        view(rig_of("omni", (50.0, 0.0, 0.0, 0.0, 0.0)))
