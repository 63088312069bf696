"""Names that were replaced before the first release are answered with the new one."""

import importlib
import re

import pytest

import stereorecal as sr

RENAMED = {
    "stereorecal.estimation": {"Beams": "MatchedRanges", "NO_BEAMS": "NO_RANGES"},
    "stereorecal.objectives": {"Images": "StereoImages"},
    "stereorecal": {
        "repaired_together": "recalibrate_many",
        "repairs_as_finished": "recalibrate_many, with finished=",
    },
    "stereorecal.online": {"Beside": "MonitorProcess"},
    "stereorecal.comparison.judges": {"rows": "row_error_px"},
    "stereorecal.recalibration": {
        "repaired_together": "recalibrate_many",
        "repairs_as_finished": "recalibrate_many, with finished=",
        "searched": "recalibrate_case",
    },
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
    assert hasattr(module, new.partition(",")[0])
    assert old not in dir(module)
    sentence = f"^{re.escape(f'{package}.{old} is now {package}.{new}; use that name.')}$"
    with pytest.raises(ImportError, match=sentence):
        getattr(module, old)
    with pytest.raises(ImportError, match=sentence):
        exec(f"from {package} import {old}")


@pytest.mark.parametrize("package", RENAMED)
def test_a_name_that_never_was_is_an_attribute_error(package: str):
    assert not hasattr(importlib.import_module(package), "nothing")


ATTRIBUTES = [
    (sr.estimation.Estimate, "beams", "matched_ranges"),
    (sr.estimation.Estimate, "depth_kept", "with_free(names, keep_depth=True)"),
    (sr.Parameters, "lenses", "intrinsics"),
    (sr.recalibration.Findings, "beams", "matched_ranges"),
    (sr.Solution, "asked", "settings"),
    (sr.Solution, "kept", "frames.used"),
    (sr.Solution, "reach", "settings.reach"),
    (sr.recalibration.FramesUsed, "looked_at", "selected"),
    (sr.Health, "mending", "correction"),
]


@pytest.mark.parametrize(("kind", "old", "new"), ATTRIBUTES, ids=[f"{k.__name__}.{old}" for k, old, _ in ATTRIBUTES])
def test_an_old_attribute_is_answered_with_the_new_one(kind: type, old: str, new: str):
    empty = kind.__new__(kind)
    sentence = re.escape(f"{kind.__name__}.{old} is now {kind.__name__}.{new}; use that name.")
    with pytest.raises(AttributeError, match=f"^{sentence}$"):
        getattr(empty, old)
    with pytest.raises(AttributeError, match=f"^'{kind.__name__}' object has no attribute 'nothing'$"):
        getattr(empty, "nothing")  # noqa: B009
