"""The matcher kit passes our matchers and fails each bad one by the check that is meant for it."""

from dataclasses import dataclass
from typing import ClassVar

import jax.numpy as jnp
import numpy as np
import pytest

from stereorecal.matching import BM, SAD, SGBM, Disparity
from stereorecal.testing import MatcherConformance, check_matcher


class TestSAD(MatcherConformance):
    matcher = SAD()


pytest.mark.slow(TestSAD.test_is_smooth)  # tests/matching/test_soft.py takes less
pytest.mark.slow(TestSAD.test_can_be_traced)  # test_twin and tests/matching hold both against NumPy


class TestBM(MatcherConformance):
    matcher = BM()


class TestSGBM(MatcherConformance):
    matcher = SGBM()


def bent(match, **attributes):
    """A SAD matcher whose result goes through `match(self, found, left)`; it runs SAD's own programs."""

    def search(self, left, right):
        return match(self, SAD(**vars(self)).search(left, right), left)

    members = {
        "search": search,
        "traceable": False,
        "smooth": False,
        "halo": None,
        "__module__": __name__,
        **attributes,
    }
    return dataclass(frozen=True)(type("Bent", (SAD,), members))()


def swapped_sign(self, found, left):
    return Disparity(-found.values, found.valid)


def credulous(self, found, left):
    return Disparity(found.values, jnp.ones_like(found.valid))


def wide(self, found, left):
    return Disparity(found.values.astype(jnp.float16), found.valid)


def beyond(self, found, left):
    return Disparity(found.values + jnp.where(jnp.arange(left.shape[0])[:, None] == 50, 40.0, 0.0), found.valid)


def far_sighted(self, found, left):
    return Disparity(found.values + 1e-4 * left.mean(), found.valid)


class Dice:
    """Loses other pixels at each call."""

    generator: ClassVar[np.random.Generator] = np.random.default_rng(0)

    def __call__(self, found):
        return Disparity(found.values, found.valid & (self.generator.random(found.valid.shape) > 0.1))


dice = Dice()


@pytest.mark.parametrize(
    ("matcher", "expected"),
    [
        (bent(swapped_sign), {"finds known shifts", "searches its range", "loses matches when rows do not align"}),
        (bent(credulous), {"invents nothing", "loses matches when rows do not align"}),
        (bent(wide), {"returns values and validity"}),
        (bent(beyond), {"searches its range"}),
        (bent(lambda self, found, left: dice(found)), {"is deterministic"}),
        (bent(lambda self, found, left: found), set()),
        (bent(far_sighted, halo=6), {"looks no farther than its halo"}),
        (bent(lambda self, found, left: found, smooth=True, soft_match=lambda *_: None), {"is smooth"}),
    ],
    ids=["sign", "credulous", "width", "range", "dice", "local class", "halo", "smooth"],
)
def test_bad_matchers_fail_by_the_right_check(matcher, expected):
    failed = {result.name: result.message for result in check_matcher(matcher) if not result.passed}
    assert set(failed) == expected | {"travels"}  # classes made in a function do not pickle
    assert all(failed.values())
