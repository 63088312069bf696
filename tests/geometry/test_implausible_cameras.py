"""Numbers that no camera has are refused where they are read: no search is begun with them."""

import numpy as np
import pytest

from stereorecal import InputError
from stereorecal.geometry import Camera


def camera(focal: float = 500.0, centre: float = 320.0, distortion: tuple[float, ...] = ()) -> Camera:
    return Camera((640, 480), np.array([[focal, 0, centre], [0, focal, 240.0], [0, 0, 1]]), np.array(distortion))


@pytest.mark.parametrize("focal", [1e300, 1e-300, 1e30, 1e7, 0.01])
def test_focal_lengths(focal: float):
    with pytest.raises(InputError, match="do not fit a camera with 640 pixels"):
        camera(focal)


@pytest.mark.parametrize("centre", [1e9, -1e9, 1e300])
def test_centres(centre: float):
    with pytest.raises(InputError, match="lies far outside of the image"):
        camera(centre=centre)


@pytest.mark.parametrize("place", range(5))
def test_distortions(place: int):
    values = [0.0] * 5
    values[place] = 1e300
    with pytest.raises(InputError, match="no lens distorts so much"):
        camera(distortion=tuple(values))


@pytest.mark.parametrize("focal", [30.0, 100_000.0])
def test_wide_and_long_lenses_are_cameras(focal: float):
    camera(focal, distortion=(-0.4, 0.2, 1e-3, 1e-3, 5e3))
