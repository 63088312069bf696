"""What images must show besides: one ordered list, of which the first that holds is the reason."""

from itertools import combinations

import numpy as np
import pytest

from stereorecal.decision import CHECKS, ENOUGH, Criterion, Decision, Reason, Seen, Verdict, reason_of

GOOD = {"matches": 2000, "covered": 0.5, "places": 40, "texture": 0.6}
SHOWN = {
    Reason.OUT_OF_BUDGET: {"cut": True},
    Reason.TOO_LITTLE_TEXTURE: {"problem": "an image is interlaced"},
    Reason.NO_MATCHES: {"matches": ENOUGH.matches - 1},
    Reason.FRAMES_DISAGREE: {"frames_disagree": True},
    Reason.CANNOT_TELL: {"by_chance": True},
    Reason.LATE_SHUTTER: {"late": True},
    Reason.REACH_EDGE: {"away": 1.01 * ENOUGH.reach},
    Reason.FEWER_MATCHES: {"lost": 1.01 * ENOUGH.lost},
    Reason.OTHER_LENSES: {"lens_change": np.nextafter(ENOUGH.lens_change, 9.0)},
    Reason.MISFIT: {"misfit_px": ENOUGH.misfit_px},
}


def said(verdict: Verdict | None, failed: Criterion | None = None, **shown) -> Reason:
    px = np.ones((2, 3))
    decision = Decision(verdict or Verdict.GOOD, np.zeros(5), 0.0, 0.0, 1.0, (2.0, 1.0), px, px, failed)
    return reason_of(None if verdict is None else decision, Seen(**(GOOD | shown)))


@pytest.mark.parametrize("reason", Reason, ids=[reason.name for reason in Reason])
def test_every_reason_has_an_advice_of_one_sentence(reason):
    assert reason.advice[0].isupper()
    assert reason.advice.endswith(".")
    assert ". " not in reason.advice
    assert "\n" not in reason.advice
    assert reason.value[0].islower()
    assert reason.healthy or not reason.accepted


def test_without_a_finding_the_verdict_is_the_reason():
    assert said(Verdict.REPAIR) is Reason.IMPROVED
    assert said(Verdict.GOOD, Criterion.GAINS) is Reason.ALREADY_GOOD
    assert said(Verdict.CANNOT_TELL, Criterion.HARMLESS) is said(None) is Reason.CANNOT_TELL
    assert said(Verdict.CANNOT_TELL, Criterion.PREDICTS) is Reason.MISFIT


def test_each_check_says_its_own_reason():
    """If it vetoes a repair, of a repair; if it doubts a good verdict, of that; always where there is no verdict."""
    assert [check.reason for check in CHECKS] == list(SHOWN)
    for check in CHECKS:
        shown = SHOWN[check.reason]
        assert said(Verdict.CANNOT_TELL, **shown) is said(None, **shown) is check.reason
        assert said(Verdict.REPAIR, **shown) is (check.reason if check.vetoes else Reason.IMPROVED)
        assert said(Verdict.GOOD, **shown) is (check.reason if check.doubts else Reason.ALREADY_GOOD)


@pytest.mark.parametrize(("first", "second"), list(combinations(range(len(CHECKS)), 2)))
def test_of_two_that_hold_the_first_is_said(first, second):
    one, other = CHECKS[first], CHECKS[second]
    shown = SHOWN[other.reason] | SHOWN[one.reason]
    assert said(None, **shown) is one.reason
    vetoed, doubted = one.vetoes or other.vetoes, one.doubts or other.doubts
    assert said(Verdict.REPAIR, **shown) is (one.reason if vetoed else Reason.IMPROVED)
    assert said(Verdict.GOOD, **shown) is (one.reason if doubted else Reason.ALREADY_GOOD)


@pytest.mark.parametrize("few", [{"matches": 0}, {"covered": 0.0, "by_chance": True}, {"places": 0}])
def test_few_matches_are_of_the_images_or_of_the_rig(few):
    """Where there is light and texture, an aligned rig would match."""
    assert said(Verdict.REPAIR, **few, enough=False) is Reason.TOO_LITTLE_TEXTURE
    assert said(Verdict.REPAIR, **few) is Reason.NO_MATCHES
    assert said(Verdict.REPAIR, enough=False) is Reason.IMPROVED  # dark images that match all the same
