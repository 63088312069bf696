"""Values of a calibration that hardly any rig has are named."""

from dataclasses import replace

import numpy as np
import pytest
from spoiled import fog

from stereorecal import BM, SAD, InputError, Solution, StereoRig, health, view
from stereorecal.geometry import Camera
from stereorecal.recalibration import Condition
from stereorecal.synthetic import default_rig


def rig_of(model: str, coefficients=(), focal: float = 75.0, metres: float = 0.1) -> StereoRig:
    matrix = np.array([[focal, 0.0, 80.0], [0.0, focal, 60.0], [0.0, 0.0, 1.0]])
    camera = Camera((160, 120), matrix, np.array(coefficients), model=model)
    return StereoRig(camera, camera, np.array([0.0, 0.0, 0.0, -metres, 0.0, 0.0]))


def look(rig: StereoRig) -> Solution:
    return health(rig, fog((160, 120)), matcher=BM(num_disparities=16), prior="exact")


@pytest.fixture(scope="module")
def looked() -> Solution:
    """At an ordinary rig, by programs that other files compile."""
    return health(default_rig().resized((160, 120)), fog((160, 120)), matcher=SAD(num_disparities=32), prior="exact")


@pytest.mark.parametrize(
    ("rig", "said"),
    [
        (rig_of("radtan"), None),
        (rig_of("radtan", focal=1500.0), "check fx"),
        (rig_of("radtan", focal=15.0), "check fx"),
        (rig_of("radtan", metres=10.0), "check the unit"),
        (rig_of("ds", (-0.99, 0.6)), "is a view of 1 degrees"),
        (rig_of("ds", (-0.2, 0.6)), None),
        (rig_of("equidistant", (-0.2, 0.0, 0.0, 0.0)), None),
        (rig_of("equidistant", (0.1, -0.2, 0.1, 0.0)), None),
    ],
)
def test_what_hardly_any_rig_has_is_named(looked: Solution, rig: StereoRig, said: str | None):
    found = replace(looked, initial=rig)
    assert found.condition is not Condition.REPAIR
    assert (said is None) == (not found.doubts)
    assert all(said in doubt and doubt in str(found) for doubt in found.doubts)
    assert found.to_dict()["doubts"] == list(found.doubts)


@pytest.mark.slow
def test_a_view_of_a_degree_is_looked_at():
    assert look(rig_of("ds", (-0.99, 0.6))).doubts


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
