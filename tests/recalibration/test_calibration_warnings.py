"""Values of a calibration that hardly any rig has are named."""

import numpy as np
import pytest
from spoiled import fog

from stereorecal import BM, InputError, StereoRig, health, view
from stereorecal.geometry import Camera


def rig_of(model: str, coefficients, focal: float = 75.0) -> StereoRig:
    matrix = np.array([[focal, 0.0, 80.0], [0.0, focal, 60.0], [0.0, 0.0, 1.0]])
    camera = Camera((160, 120), matrix, np.array(coefficients), model=model)
    return StereoRig(camera, camera, np.array([0.0, 0.0, 0.0, -0.1, 0.0, 0.0]))


@pytest.mark.slow(after=2)
@pytest.mark.parametrize(
    ("model", "coefficients", "said"),
    [
        ("ds", (-0.99, 0.6), "is a view of 1 degrees"),
        ("ds", (-0.2, 0.6), None),
        ("equidistant", (-0.2, 0.0, 0.0, 0.0), None),
        ("equidistant", (0.1, -0.2, 0.1, 0.0), None),
    ],
)
def test_wide_lenses_that_no_camera_has_are_named(model, coefficients, said):
    found = health(rig_of(model, coefficients), fog((160, 120)), matcher=BM(num_disparities=16), prior="exact").doubts
    assert (said is None) == (not found)
    assert all(said in one for one in found)


@pytest.mark.parametrize(
    ("model", "coefficients"),
    [
        ("equidistant", (-5.0, 0.0, 0.0, 0.0)),
        ("omni", (1.5, -3.0, 0.0, 0.0, 0.0)),
        ("omni", (50.0, 0.0, 0.0, 0.0, 0.0)),
    ],
)
def test_a_lens_that_folds_the_image_back_far_inside_is_none(model, coefficients):
    with pytest.raises(InputError, match=r"lens ends .* px from the principal point, by its coefficients"):
        rig_of(model, coefficients)


def test_a_lens_without_resolution_has_no_view():
    with pytest.raises(InputError, match=r"px per radian in images 160 px wide"):
        view(rig_of("ds", (0.11, 0.41), focal=4.5))
