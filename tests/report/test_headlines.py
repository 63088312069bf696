"""What to do, and where depth cannot be trusted, in sentences."""

import html

import pytest
from made_up_repair import made_up, misfit

from stereorecal.report.repair_page import repair_page
from stereorecal.report.repair_report import Conclusion

CENTRE, LOWER_RIGHT = 27, 47
HEADLINES = {
    "Use the new calibration": (Conclusion.REPAIRED, misfit(before={0: 9.0})),
    "Use the new calibration, but do not trust depth at the upper left": (Conclusion.REPAIRED, misfit(after={0: 0.9})),
    "Use the new calibration, but do not trust depth in 5 parts of the image": (
        Conclusion.REPAIRED,
        misfit(after=dict.fromkeys((0, 7, CENTRE, 40, LOWER_RIGHT), 0.9)),
    ),
    "Use the new calibration, but do not trust depth nearly everywhere": (
        Conclusion.REPAIRED,
        misfit(after=dict.fromkeys(range(40), 0.9)),
    ),
    "Keep the calibration that you have: it is good": (Conclusion.GOOD, misfit(after={0: 0.9})),
    "Keep the calibration that you have, but do not trust depth at the centre and lower right": (
        Conclusion.GOOD,
        misfit(before={CENTRE: 0.9, LOWER_RIGHT: -0.5}),
    ),
    "Not repaired: the calibration stays as it is, and its depth cannot be trusted": (
        Conclusion.REFUSED,
        misfit(before={0: 9.0}, after={CENTRE: 0.9}),
    ),
    "Cannot tell whether the calibration is right; it stays as it is": (Conclusion.UNKNOWN, None),
}


def page(**changes) -> str:
    """Of a made-up repair, with small pictures and none of the search."""
    return repair_page(made_up((64, 48), measured=False, climbs=[], **changes))


def where(**changes) -> list[str]:
    """What the page says of the places where depth can be trusted, or cannot."""
    told = page(**changes).partition("<b>Where:</b> ")[2].partition("</p>\n</div>")[0]
    return html.unescape(told).split("</p>\n<p>") if told else []


@pytest.mark.parametrize(("said", "case"), HEADLINES.items(), ids=list(HEADLINES))
def test_headlines(said: str, case):
    conclusion, left = case
    assert f"<h1>{said}</h1>" in page(conclusion=conclusion, misfit=left)


def test_a_look_says_what_would_be_done():
    said = page(searched=False)
    assert "<h1>Repair the calibration</h1>" in said
    assert "This is a look at the images, which changes nothing" in said


def test_every_part_is_named():
    """Of five parts, three would leave two that are cleared without a word."""
    left = misfit(after={0: 0.9, 1: 0.8, 7: 0.5, CENTRE: -0.4, 40: 0.3, LOWER_RIGHT: 0.3})
    assert where(misfit=left)[0] == (
        "In 6 of the 48 matched regions of the view the epipolar error exceeds 0.2 px (0.90 px at worst), at the "
        "upper left, upper right, centre, lower left and lower right: do not trust depth there."
    )


@pytest.mark.parametrize(
    ("left", "said"),
    [
        (misfit(after=dict.fromkeys(range(36), 0.9)), "nearly everywhere: do not"),  # none is cleared
        (misfit(after={0: 0.35}, error=[0.1] * 48), "In none of the 48 matched regions"),  # which noise explains
        (misfit(after={0: 0.9}, frames=3), "In 1 of the 48 matched regions"),  # places are counted, not frames
    ],
)
def test_how_many_regions(left, said: str):
    assert said in where(misfit=left)[0]


def test_what_is_kept_is_spoken_of():
    """The candidate's errors say nothing about another calibration."""
    left = misfit(before={0: 9.0}, after={CENTRE: 0.9})
    kept, candidate = where(conclusion=Conclusion.REFUSED, misfit=left)
    assert kept.startswith("With the calibration that you keep, in 1 of the 48")
    assert "9.00 px at worst), at the upper left" in kept
    assert candidate.startswith("With the candidate, which was rejected, in 1 of the 48")
    assert candidate.endswith("(0.90 px at worst), at the centre: it does not fit there.")
    (alone,) = where(conclusion=Conclusion.GOOD, misfit=left)
    assert "9.00 px" in alone


def test_what_was_not_seen():
    left = {key: value[24:] for key, value in misfit().items()}
    said = where(misfit=left)
    assert said[0].startswith("In none of the 24 matched regions of the view")
    assert said[1].startswith("Little or nothing matched at the upper left, upper middle and upper right:")


def test_a_count_alone_does_not_say_where():
    (said,) = where(misfit=None)
    assert "not known where in the image depth can be trusted" in said
    assert where(conclusion=Conclusion.UNKNOWN, misfit=None) == []
