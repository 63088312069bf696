"""Figures of a repair: scales that hold before and after."""

import base64
import re

import cv2
import numpy as np
import pytest
from parts_of_repairs import _bins, density, expected_figure, field_figures, histogram_figure, outline

from stereorecal.report.repair_report import Rows

IMAGE = np.full((60, 80), 128.0)
NAMES = ("before", "after")


def words(figure: str) -> list[str]:
    return [text.replace("\N{MINUS SIGN}", "-") for text in re.findall(r"<text[^>]*>([^<]*)</text>", figure)]


@pytest.fixture(scope="module")
def rows() -> Rows:
    rng = np.random.default_rng(0)
    field = rng.normal(0.0, 0.1, (18, 24))
    return Rows(-12.0 + field, field, rng.normal(-12.0, 0.1, 500), np.repeat([0.1, 0.5], [375, 125]))


def test_both_maps_hold_what_was_before(rows: Rows):
    for figure in field_figures(rows, IMAGE, NAMES, ([], [])):
        assert {"-10", "-1", "-0.2", "0", "0.2", "1", "10"} <= set(words(figure))


def test_the_histogram_holds_all_and_says_how_much_is_harmless(rows: Rows):
    figure = histogram_figure(rows, NAMES)
    assert {"-10", "0", "10", "before: 0 % within 0.2 px", "after: 75 % within 0.2 px"} <= set(words(figure))


def test_rows_that_are_spread_make_no_peak_far_from_zero():
    """Where bins are wide; and none where the axis becomes logarithmic."""
    bins = _bins(12.0)
    spread = density(np.random.default_rng(0).uniform(-12, 12, 200_000), bins)
    np.testing.assert_allclose((spread * np.diff(bins)).sum(), 1.0)
    np.testing.assert_allclose(spread[np.diff(bins) > 0.1], 1 / 24, rtol=0.1)
    wide, narrow = (density(np.random.default_rng(1).normal(at, by, 5000), bins) for at, by in ((-9, 0.5), (0, 0.1)))
    assert narrow.max() > 3 * wide.max()
    steps = np.diff(bins)[1:] / np.diff(bins)[:-1]
    assert steps.max() < 1.5


def test_colour_bars_are_opaque(rows: Rows):
    """Over a dark page, half of it would shine through."""
    for figure in (*field_figures(rows, IMAGE, NAMES, ([], [])), expected_figure(np.ones((13, 17)), IMAGE)):
        coded = [base64.b64decode(data) for data in re.findall(r'base64,([^"]+)"', figure)]
        pictures = [cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) for data in coded]
        (bar,) = [picture for picture in pictures if picture.shape[0] > 5 * picture.shape[1]]
        assert (bar[..., 3] == 255).all()


def test_regions_are_outlined_together():
    assert outline([]) == []
    assert len(outline([9])) == 4
    assert len(outline([9, 10])) == 6  # what they share is no edge
    assert ((1 / 8, 1 / 6), (2 / 8, 1 / 6)) in outline([9])
