"""Counts are comparable within one view only, so the view is an argument, and the default is the rig's own."""

from dataclasses import replace

import numpy as np
import pytest

from stereorecal.geometry import view
from stereorecal.matching import SAD
from stereorecal.scoring.host import rectify, score

SAD_32 = SAD(num_disparities=32)


def test_default_is_the_view_of_the_rig(scene):
    given_scene = scene()
    rig, pairs = given_scene.rig, given_scene.pairs
    assert score(rig, pairs, matcher=SAD_32) == score(rig, pairs, matcher=SAD_32, view=view(rig))


def test_the_view_alone_moves_the_count(scene):
    """The same calibration counts by percents more or less as the picture is zoomed."""
    given_scene = scene()
    rig, pairs, own = given_scene.rig, given_scene.pairs, view(given_scene.rig)
    plain = score(rig, pairs, matcher=SAD_32, view=own).count
    zoomed = score(rig, pairs, matcher=SAD_32, view=replace(own, focal=0.8 * own.focal)).count
    assert abs(zoomed - plain) > 0.02 * plain


def test_rectified_images_are_in_the_view(scene):
    given_scene = scene()
    rig, pair, own = given_scene.rig, given_scene.pairs[0], view(given_scene.rig)
    moved = replace(own, centre_row=own.centre_row + 10.0)
    plain, shifted = rectify(rig, pair)[0], rectify(rig, pair, view=moved)[0]
    assert np.abs(plain[40:200] - shifted[50:210]).mean() == pytest.approx(0.0, abs=0.05)
    assert np.abs(plain - shifted).mean() > 1.0
