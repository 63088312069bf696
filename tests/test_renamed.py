"""Names that were replaced before the first release are answered with the new one."""

import importlib

import pytest

RENAMED = {
    "stereorecal.objectives": {"Images": "StereoImages"},
    "stereorecal.scoring": {"Legible": "ImageQuality", "legible": "image_quality", "informative": "select_frames"},
    "stereorecal.scoring.host": {
        "compile_ahead": "compile_in_background",
        "partners": "match_pixels",
        "ranged": "with_measured_range",
        "refuse_mixed_up": "refuse_swapped_images",
    },
}
CASES = [(package, old, new) for package, names in RENAMED.items() for old, new in names.items()]


@pytest.mark.parametrize(("package", "old", "new"), CASES, ids=[f"{package}.{old}" for package, old, _ in CASES])
def test_an_old_name_is_answered_with_the_new_one(package: str, old: str, new: str):
    module = importlib.import_module(package)
    assert hasattr(module, new)
    assert old not in dir(module)
    sentence = rf"^{package}\.{old} is now {package}\.{new}; use that name\.$"
    with pytest.raises(ImportError, match=sentence):
        getattr(module, old)
    with pytest.raises(ImportError, match=sentence):
        exec(f"from {package} import {old}")


@pytest.mark.parametrize("package", RENAMED)
def test_a_name_that_never_was_is_an_attribute_error(package: str):
    assert not hasattr(importlib.import_module(package), "nothing")
