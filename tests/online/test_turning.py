"""How a rig turns between two left images, of any lens: against images of a texture that lies on a sphere."""

import numpy as np
import pytest
from lenses import WIDE_LENSES
from parts_of_estimates import small, turn

from stereorecal.geometry import Camera, rotation_from_vector

SIZE = (320, 240)
PINHOLE = Camera(SIZE, np.array([[260.0, 0, 160], [0, 260.0, 120], [0, 0, 1]]), np.array([-0.05, 0.01, 0, 0, 0]))
MATRIX = np.array([[112.0, 0, 161.0], [0, 112.5, 118.0], [0, 0, 1]])


def taken(camera: Camera, turned: np.ndarray) -> np.ndarray:
    """The image of the texture once the camera was turned: x(now) = turned x(before)."""
    draw = np.random.default_rng(0)
    waves, phases = draw.normal(0.0, 14.0, (40, 3)), draw.uniform(0.0, 2.0 * np.pi, 40)
    pixels = np.stack(np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1])), axis=-1).astype(float)
    directions = np.asarray(camera.directions(pixels)) @ turned
    return np.nan_to_num(128.0 + 12.0 * np.cos(directions @ waves.T + phases).sum(axis=-1)).clip(0.0, 255.0)


@pytest.mark.parametrize("model", ["radtan", "equidistant", "ds"])
def test_a_turn_is_found_through_any_lens(model: str):
    """Far aside, too: what lies across the view has no place on a plane."""
    lens = PINHOLE if model == "radtan" else Camera(SIZE, MATRIX, np.array(WIDE_LENSES[model]), model=model)
    vector = np.radians([0.4, -0.6, 0.3])
    before, now = (small(taken(lens, np.asarray(turned))) for turned in (np.eye(3), rotation_from_vector(vector)))
    found = turn(lens, before, now)
    assert found is not None
    np.testing.assert_allclose(np.degrees(found), np.degrees(vector), atol=0.03)
