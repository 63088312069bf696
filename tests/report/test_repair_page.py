"""The page of a repair: whole, self-contained, escaped, with words for every picture."""

import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from made_up_repair import EVIL, made_up, sight
from pages import Reader, assert_whole_and_alone

from stereorecal.report.repair_page import repair_page
from stereorecal.report.repair_report import Conclusion


@pytest.fixture(scope="module")
def page() -> str:
    return repair_page(made_up())


def test_it_is_whole_and_alone_and_has_every_part(page: str):
    assert_whole_and_alone(page)
    assert EVIL not in page
    read = Reader(page)
    assert len(read.all("script")) == 1
    assert read.heads(2) == [
        "One rectified pair",
        "Disparity",
        "Which axis moved, and by how much",
        "Refined intrinsics",
        "Epipolar error over the view",
        "Errors of depth",
        "The search",
        "Frames",
        "To run it again",
    ]
    (policy,) = [a["content"] for a in read.all("meta") if a.get("http-equiv") == "Content-Security-Policy"]
    assert policy is not None
    assert policy.startswith("default-src 'none'")


def test_every_picture_has_words(page: str):
    read = Reader(page)
    assert len(read.all("img")) == 4 + 1  # of pairs and disparities, and the scale of the latter
    assert all((a.get("alt") or "").endswith(".") for a in read.all("img"))
    assert len(read.all("svg")) == 4
    assert all(a.get("role") == "img" and a.get("aria-label") for a in read.all("svg"))
    labels = [slider["aria-label"] for slider in read.all("input")]
    assert [(label or "").partition(",")[0] for label in labels] == ["The rectified pair", "The disparity"]


def text_of(page: str) -> str:
    """What is read, on one line."""
    return " ".join(unescape(re.sub(r"<style>.*?</style>|<script>.*?</script>|<[^>]+>", " ", page, flags=re.S)).split())


HOSTILE = [EVIL, '" onload="alert(1)', "a b 'c'.png", "very-long-" * 60, "{{ 7 * 7 }}"]


@pytest.mark.parametrize("name", HOSTILE, ids=["script", "quotes", "spaces", "long", "template"])
def test_names_stay_text(name: str):
    frames = [(name, "used", ""), ("other", "left out", name)]
    page = repair_page(made_up(measured=False, name=name, frame=name, frames=frames, command=name, settings={}))
    assert text_of(page).count(name) == 6
    assert not [a for _, a in Reader(page).elements if "onload" in a]


def test_wide_things_scroll_and_are_reached_by_keyboard(page: str):
    boxes = [a for tag, a in Reader(page).elements if a.get("class") == "wide" or tag == "pre"]
    assert len(boxes) == 9
    assert all((a.get("tabindex"), a.get("role")) == ("0", "region") and a.get("aria-label") for a in boxes)


@pytest.mark.parametrize("conclusion", [Conclusion.GOOD, Conclusion.REFUSED])
def test_a_page_that_keeps_the_calibration_says_so(conclusion: Conclusion):
    page = repair_page(made_up(conclusion=conclusion))
    heads = [text.strip() for text in Reader(page).texts["th"]]
    assert not {"before", "after", "after, 95 %", "candidate, 95 %"} & set(heads)
    assert heads[1:3] == ["kept", "candidate"]
    depth = ["distance", "kept, 95 %"] if conclusion is Conclusion.GOOD else []
    assert [head for head in heads if head == "distance" or head.startswith("kept,")] == depth
    text = text_of(page)
    assert "The candidate that the search ended at was rejected" in text
    assert "of the calibration that is kept and of the rejected candidate" in text
    assert "Expect of the calibration that you get" not in text
    assert ("Expect of the calibration that you keep" in text) == (conclusion is Conclusion.GOOD)
    assert [title for title in Reader(page).heads(2) if "moved" in title] == []


def test_what_nobody_can_tell_has_no_empty_tables():
    nothing = {"misfit": None, "axes": (), "depths": (), "intrinsics": (), "remarks": ()}
    read = Reader(repair_page(made_up(conclusion=Conclusion.UNKNOWN, measured=False, **nothing)))
    assert read.opened == []
    assert read.all("svg") == []
    heads = ["One rectified pair", "Disparity", "The search", "Frames", "To run it again"]
    assert read.heads(2) == heads


def test_no_column_of_dashes():
    axes = [replace(axis, half_width=None) for axis in made_up().axes]
    read = Reader(repair_page(made_up(measured=False, axes=axes, depths=(), intrinsics=())))
    assert not [head for head in read.texts["th"] if "95 %" in head]
    assert "Errors of depth" not in read.texts["h2"]


def test_what_is_told(page: str):
    """A change has its interval beside it; what to expect stands above; all that repeats the run is there."""
    text = text_of(page)
    assert "axis before after change, 95 % pitch [°] 0.100 0.900 +0.800 ± 0.002" in text
    assert "weakly observable, mostly from the prior 1.000 2.000 +1.000 From" in text
    assert "left focal length [px] 500.00 501.25 +1.25 ± 0.75" in text
    assert "1.8 m 13 to 15 cm too near -8.1 % to -7.2 % -18 to +22 mm -1.0 % to +1.2 %" in text
    assert "36 m 1.1 m too far to beyond infinity +3.0 % to beyond infinity" in text
    assert text.index(made_up().expected_said) < 900
    assert " B " not in text  # of which nobody is told what it is
    assert [text for text in Reader(page).texts["pre"] if text.startswith("python -m")] == [made_up().command]
    assert '"seed": 7, "matcher": { "block_size": 9 }, "stages": [ "a", "b" ]' in text
    assert 'Calibration after, as a calib.json {"T": [1.0, 0.0, 0.1]}' in text


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("size", [(160, 120), (1800, 1350), (1200, 2000)], ids=str)
def test_it_can_be_mailed(size):
    assert len(repair_page(made_up(size)).encode()) < 3_000_000


def test_nothing_matched():
    seen = sight((160, 120), 0)
    empty = replace(seen, valid=np.zeros_like(seen.valid))
    assert "0 % of the pixels" in repair_page(made_up((64, 48), measured=False, before=empty, after=empty))
