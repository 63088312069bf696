"""The conformance kit of matchers: the properties that scores rely on.

They run on random texture that is smooth enough to interpolate and rich enough to match, shifted by known disparities.
"""

import pickle
from dataclasses import replace
from typing import ClassVar

import cv2
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.matching import AbstractMatcher
from stereorecal.testing._checks import CheckResult, Checks

_SIZE = (160, 96)
_BORDER = 24  # pixels at the border that results are not judged on: a matching window may not fit there
_COUNT = 32  # num_disparities of most checks
Image = Float[np.ndarray, "h w"]
MATCHER_CHECKS = Checks()


@MATCHER_CHECKS.add()
def returns_values_and_validity(matcher: AbstractMatcher) -> None:
    """It returns values (h, w) float32 and validity (h, w) bool, and does not modify its inputs."""
    left, right = _shifted_wall(5)
    before = left.copy(), right.copy()
    found = matcher_at(matcher).match(left, right)
    shape = (_SIZE[1], _SIZE[0])
    assert found.values.shape == found.valid.shape == shape, f"it returns {found.values.shape} for images {shape}"
    assert found.values.dtype == np.float32, f"values are {found.values.dtype}, not float32"
    assert found.valid.dtype == bool, f"validity is {found.valid.dtype}, not bool"
    assert np.array_equal(left, before[0]), "it modifies the left image"
    assert np.array_equal(right, before[1]), "it modifies the right image"


@MATCHER_CHECKS.add()
def finds_known_shifts(matcher: AbstractMatcher) -> None:
    """It finds the disparity x_left - x_right of shifted texture at most pixels, 0 and half pixels included."""
    for shift in (0, 7, 12.5):
        _assert_finds(matcher_at(matcher), shift)


@MATCHER_CHECKS.add()
def searches_its_range(matcher: AbstractMatcher) -> None:
    """It searches from `min_disparity` on, which may be negative; no disparity outside its range is valid."""
    for lowest, shift in ((-8, -4), (4, 9)):
        ranged = matcher_at(matcher, lowest, 24)
        _assert_finds(ranged, shift)
        found = ranged.match(*_shifted_wall(shift))
        values = np.asarray(found.values)[np.asarray(found.valid)]
        assert values.min() > lowest - 1, f"it finds {values.min()} below min_disparity {lowest}"
        assert values.max() < lowest + 24, f"it finds {values.max()}, beyond its range"


@MATCHER_CHECKS.add()
def invents_nothing(matcher: AbstractMatcher) -> None:
    """Unrelated images leave a good part of the pixels invalid, and flat images all of them."""
    left, right = _texture(0), _texture(1)
    share = float(np.mean(matcher_at(matcher).match(left, right).valid))
    assert share < 0.7, f"{100 * share:.0f} % of the pixels of unrelated images match"
    flat = np.full_like(left, 128.0)
    assert not np.any(matcher_at(matcher).match(flat, flat).valid), "flat images match"


@MATCHER_CHECKS.add()
def loses_matches_when_rows_do_not_align(matcher: AbstractMatcher) -> None:
    """A vertical misalignment of six rows costs it a quarter of its matches: the count relies on this."""
    left, right = _shifted_wall(6)
    aligned = np.sum(matcher_at(matcher).match(left, right).valid)
    shifted = np.sum(matcher_at(matcher).match(left, np.roll(right, 6, axis=0)).valid)
    assert shifted < 0.75 * aligned, f"misaligned by 6 rows it still finds {shifted / aligned:.2f} of its matches"


@MATCHER_CHECKS.add()
def is_deterministic(matcher: AbstractMatcher) -> None:
    """The same images give the same result."""
    first, second = (matcher_at(matcher).match(*_shifted_wall(5)) for _ in range(2))
    same = np.array_equal(first.values, second.values) and np.array_equal(first.valid, second.valid)
    assert same, "two runs differ"


@MATCHER_CHECKS.add()
def asks_for_its_range(matcher: AbstractMatcher) -> None:
    """It raises InputError without `num_disparities`, or with more of them than the image has columns."""
    for count in (None, _SIZE[0] + 32):
        try:
            replace(matcher, min_disparity=0, num_disparities=count).match(*_shifted_wall(5))
        except InputError:
            continue
        why = "the range is not set" if count is None else f"the image has {_SIZE[0]} columns"
        raise AssertionError(f"it matches with num_disparities={count}, though {why}; raise InputError")


@MATCHER_CHECKS.add()
def travels(matcher: AbstractMatcher) -> None:
    """It pickles, and the copy is equal and has the same hash: programs are compiled once for each matcher."""
    assert pickle.loads(pickle.dumps(matcher)) == matcher, "a pickled copy is not equal"
    assert hash(matcher) == hash(pickle.loads(pickle.dumps(matcher))), "a copy has another hash"


@MATCHER_CHECKS.add(lambda matcher: matcher.traceable)
def can_be_traced(matcher: AbstractMatcher) -> None:
    """Under jit and vmap it finds what it finds eagerly."""
    traced, (left, right) = matcher_at(matcher), _shifted_wall(5)
    expected = traced.match(left, right)
    compiled = jax.jit(traced.match)(left, right)
    both = jax.vmap(traced.match)(jnp.stack([left, left]), jnp.stack([right, right]))
    batched = jax.tree.map(lambda leaf: leaf[1], both)
    for name, found in (("compiled", compiled), ("batched", batched)):
        differs = np.mean(np.asarray(found.valid) != np.asarray(expected.valid))
        assert differs < 1e-3, f"{name}, {100 * differs:.1f} % of the pixels differ"


@MATCHER_CHECKS.add(lambda matcher: matcher.smooth)
def is_smooth(matcher: AbstractMatcher) -> None:
    """`soft_match` has confidences in [0, 1] that tend to `match`'s validity, and a finite gradient other than 0."""
    smooth, (left, right) = matcher_at(matcher), _shifted_wall(5.5)
    confidence = np.asarray(smooth.soft_match(left, right, 1e-4).confidence).sum(axis=0)
    assert confidence.min() >= 0.0, "a confidence is negative"
    assert confidence.max() <= 1.0 + 1e-4, "a confidence exceeds 1"
    valid = np.asarray(smooth.match(left, right).valid)
    differs = float(np.mean(np.abs(confidence - valid)))
    assert differs < 0.05, f"at temperature 1e-4 it differs from `match` at {100 * differs:.1f} % of the pixels"
    gradient = jax.grad(lambda image: smooth.soft_match(left, image, 0.1).confidence.sum())(jnp.asarray(right))
    assert np.isfinite(gradient).all(), "its gradient is not finite"
    assert np.any(np.asarray(gradient) != 0), "its gradient is 0"


@MATCHER_CHECKS.add(lambda matcher: matcher.halo is not None)
def looks_no_farther_than_its_halo(matcher: AbstractMatcher) -> None:
    """Given some rows with its halo around them, it finds in these rows what it finds in the whole image."""
    ranged, (left, right), halo = matcher_at(matcher), _shifted_wall(5), matcher.halo
    assert halo is not None
    whole = ranged.match(left, right)
    first, last = 40, 56
    start = max(0, first - max(halo, matcher.block_size // 2 + 1))  # the texture check looks that far
    seen, kept = np.s_[start : last + first - start], np.s_[first - start : last - start]
    part = ranged.match(left[seen], right[seen])
    for name in ("values", "valid"):
        here, there = np.asarray(getattr(part, name))[kept], np.asarray(getattr(whole, name))[first:last]
        assert np.array_equal(here, there), f"{name} depend on rows more than {halo} away"


def check_matcher(matcher: AbstractMatcher) -> tuple[CheckResult, ...]:
    """Run the conformance checks that apply to the matcher, without pytest; one result for each check.

    The kit sets the disparity range: it replaces `min_disparity` and `num_disparities`.
    """
    return MATCHER_CHECKS.run(matcher)


class MatcherConformance:
    """Inherit from it and set `matcher`; pytest then runs every check that applies as a test:
    `class TestMine(MatcherConformance): matcher = Mine()`.
    """

    matcher: ClassVar[AbstractMatcher]

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        MATCHER_CHECKS.add_tests(cls, cls.matcher)


def matcher_at(matcher: AbstractMatcher, lowest: int = 0, count: int = _COUNT) -> AbstractMatcher:
    """The matcher with the kit's disparity range."""
    return replace(matcher, min_disparity=lowest, num_disparities=count)


def _texture(seed: int, width: int = _SIZE[0]) -> Image:
    noise = np.random.default_rng(seed).normal(size=(_SIZE[1], width))
    smooth = cv2.GaussianBlur(noise, (0, 0), 1.5)
    return np.clip(128.0 + 40.0 * smooth / smooth.std(), 0, 255).astype(np.float32)


def _shifted_wall(shift: float) -> tuple[Image, Image]:
    """Left and right image of a wall at disparity `shift`: what is at x in the left image is at x - shift in the right.

    Each image is shifted by half of it, so that interpolation blurs both alike.
    """
    wide, margin = _texture(7, _SIZE[0] + 128), 64
    columns = np.arange(_SIZE[0], dtype=np.float32)[None].repeat(_SIZE[1], axis=0)
    rows = np.arange(_SIZE[1], dtype=np.float32)[:, None].repeat(_SIZE[0], axis=1)
    left, right = (
        cv2.remap(wide, columns + np.float32(margin + half), rows, cv2.INTER_CUBIC) for half in (-shift / 2, shift / 2)
    )
    return np.clip(left, 0, 255), np.clip(right, 0, 255)


def _assert_finds(matcher: AbstractMatcher, shift: float) -> None:
    found = matcher.match(*_shifted_wall(shift))
    inner = np.s_[_BORDER:-_BORDER, _BORDER + _COUNT : -_BORDER]
    valid, values = np.asarray(found.valid)[inner], np.asarray(found.values)[inner]
    assert valid.mean() > 0.7, (
        f"at a shift of {shift} pixels it finds {100 * valid.mean():.1f} % of the disparities, not over 70 %"
    )
    error = float(np.median(np.abs(values[valid] - shift)))
    assert error < 0.3, f"at a shift of {shift} it is off by {error:.2f} pixels"
