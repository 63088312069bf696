"""Ranges from tables."""

import numpy as np
import pytest

import stereorecal as sr


def test_a_table(tmp_path):
    """The horizon is a range, too."""
    path = tmp_path / "ranges.csv"
    path.write_text("pair,column,row,metres,sigma\nfirst,10.5,20,3.5,0.1\n\n1,1,2,inf,\n", encoding="utf-8-sig")
    one, two = sr.io.load_ranges(path)
    assert (one.pair, one.left_pixel, one.metres, one.sigma) == ("first", (10.5, 20.0), 3.5, 0.1)
    assert (two.pair, two.left_pixel, two.metres, two.sigma) == ("1", (1.0, 2.0), np.inf, None)


def test_distances_along_the_optical_axis(tmp_path):
    path = tmp_path / "ranges.csv"
    path.write_text("pair,column,row,depth,sigma\n0,10,20,3.5,0.1\n")
    (one,) = sr.io.load_ranges(path)
    assert (one.metres, one.sigma, one.along) == (3.5, 0.1, "axis")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty"),
        ("pair,x,y\n", "first line"),
        (
            "pair,column,row,distance\n0,1,2,3\n",
            "must be pair,column,row,metres,sigma or .* or pair,column,row,depth, div",
        ),
        (",,\n", "first line"),
        ("pair,column,row,metres\n", "no ranges"),
        ("pair,column,row,metres\n0,1,2,far\n", "line 2"),
        ("pair,column,row,metres\n0,1,2,-3\n", "line 2: a range of -3.0 m"),
        ("pair,column,row,metres,sigma\n0,1,2,3,4,5\n", "line 2: there are 6 cells under 5 headings"),
        ("pair,column,row,metres\n0,1,2,3\n\n0\n", "line 4: '' is no number"),
        ("pair,column,row,metres,sigma\n0,1,2,3,nan\n", "line 2"),
        ("pair,column,row,metres,sigma\n0,1,2,1e400,\n", "no number that can be used"),
        ("pair,column,row,metres\n0,1,2,1_0\n", "no number that can be used"),
        ("pair;column;row;metres\n0;1;2;3\n", "divided by commas"),
        ("pair\tcolumn\trow\tmetres\n0\t1\t2\t3\n", "divided by commas"),
    ],
)
def test_tables_that_make_no_sense(tmp_path, text, said):
    path = tmp_path / "ranges.csv"
    path.write_text(text)
    with pytest.raises(sr.InputError, match=said):
        sr.io.load_ranges(path)
