"""Parameters that make no sense are refused."""

import pytest
from stereorecal_ros import Settings

from stereorecal import InputError


@pytest.mark.parametrize(
    "wrong",
    [
        {"transport": "theora"},
        {"tolerance": -1.0},
        {"tolerance": float("nan")},
        {"keep_every": float("inf")},
        {"silent_after": 0.0},
        {"share": 0.0},
        {"share": 1.5},
        {"matcher": "magic"},
        {"calibration": ("a", "b", "c")},
    ],
    ids=str,
)
def test_settings_that_make_no_sense(wrong):
    with pytest.raises(InputError):
        Settings(**wrong)
