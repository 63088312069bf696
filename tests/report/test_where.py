"""What to do, and where depth cannot be trusted, in sentences."""

import html

import pytest
from made_up_repair import made_up, misfit

from stereorecal.report.repair_page import repair_page
from stereorecal.report.repair_report import Conclusion

CENTRE, LOWER_RIGHT = 27, 47


def page(**changes) -> str:
    """The page of a made-up repair, with small pictures."""
    return repair_page(made_up((64, 48), measured=False, **changes))


def where(**changes) -> list[str]:
    """What the page says of the places where depth can be trusted, or cannot."""
    told = page(**changes).partition("<b>Where:</b> ")[2].partition("</p>\n</div>")[0]
    return html.unescape(told).split("</p>\n<p>") if told else []


def test_the_verdict_is_that_of_the_text():
    """And a look says what it is."""
    for conclusion in Conclusion:
        report = made_up(conclusion=conclusion)
        assert f"<h1>{html.escape(report.verdict)}</h1>\n<p>{report.advice}</p>" in page(conclusion=conclusion)
    assert "This is a look at the images, which changes nothing" in page(searched=False)


def test_every_part_is_named():
    """All five parts are named: three would leave two that are cleared without a word."""
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
        (misfit(after={0: 0.9, 1: 1.2}, error=[0.01, 0.3] * 24), "(1.20 px at worst)"),  # not the surest
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
