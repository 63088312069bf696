"""Matchers by name; what OpenCV's habits lead to is refused in one sentence with the right call."""

import dataclasses
import pickle
import re
from functools import partial

import pytest

from stereorecal import InputError
from stereorecal.matching import BM, SAD, SGBM, as_matcher

CLASSES = (SAD, BM, SGBM)
CAMEL = {
    "minDisparity": ("min_disparity", -4),
    "numDisparities": ("num_disparities", 128),
    "blockSize": ("block_size", 9),
    "uniquenessRatio": ("uniqueness_ratio", 5),
    "textureThreshold": ("texture_threshold", 20),
    "disp12MaxDiff": ("disp12_max_diff", 2),
    "preFilterCap": ("pre_filter_cap", 40),
}


@pytest.mark.parametrize("cls", CLASSES)
def test_a_name_is_the_matcher_with_its_default_options(cls):
    assert as_matcher(cls.__name__.lower()) == cls()


def test_nothing_is_sad_and_a_matcher_is_itself():
    assert as_matcher(None) == SAD()
    given = SGBM(num_disparities=32)
    assert as_matcher(given) is given


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("sgmb", "unknown matcher 'sgmb'; did you mean sgbm?"),
        ("census", "unknown matcher 'census'; installed: bm, sad, sgbm."),
        (SGBM, "matcher is the class SGBM; make one of it, such as sr.SGBM()."),
        (64, "matcher is a int; give a name (bm, sad, sgbm) or a matcher such as sr.SGBM(num_disparities=128)."),
    ],
)
def test_what_is_none_is_refused_in_a_sentence(given, said):
    with pytest.raises(InputError, match=f"^{re.escape(said)}$"):
        as_matcher(given)


@pytest.mark.parametrize("cls", CLASSES)
def test_options_have_names(cls):
    """OpenCV's order is another for each of its matchers; copies and pickles are as of any dataclass."""
    assert [snake for snake, _ in CAMEL.values()] == [option.name for option in dataclasses.fields(cls)]
    with pytest.raises(InputError, match=rf"name the options of {cls.__name__}, as in sr\.{cls.__name__}\(num_disp"):
        cls(0, 64)
    matcher = cls(min_disparity=-2, num_disparities=48)
    assert pickle.loads(pickle.dumps(matcher)) == matcher
    assert dataclasses.replace(matcher, block_size=7).block_size == 7
    assert hash(cls(min_disparity=-2, num_disparities=48)) == hash(matcher)


@pytest.mark.parametrize("cls", CLASSES)
@pytest.mark.parametrize("camel", CAMEL)
def test_opencvs_spelling_is_answered_with_its_own(cls, camel):
    snake, value = CAMEL[camel]
    with pytest.raises(InputError) as refusal:
        cls(**{camel: value})
    assert str(refusal.value) == f"unknown option of {cls.__name__} {camel!r}; did you mean {snake}?"
    assert getattr(cls(**{snake: value}), snake) == value  # what it says works


@pytest.mark.parametrize(
    ("option", "close"),
    [("num_disparity", "num_disparities"), ("blocksize", "block_size"), ("P1", None)],
)
def test_options_that_it_does_not_have(option, close):
    """Also one beside others that it has, and where it is copied."""
    for make in (SGBM, partial(SGBM, pre_filter_cap=9), partial(dataclasses.replace, SGBM())):
        with pytest.raises(InputError, match=f"unknown option of SGBM '{option}'") as refusal:
            make(**{option: 5})
        assert str(refusal.value).count(". ") == 0
        assert (f"did you mean {close}?" if close else "choose one of: min_disparity, num_d") in str(refusal.value)
