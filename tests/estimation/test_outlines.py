"""Rectangles of places: sums and squares against the rectangles themselves."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import _rectangle, _squares, _sums, outlines

from stereorecal.estimation import PLACES, Normal

N = PLACES[0] * PLACES[1]
LABELS = [
    ((np.arange(N) // PLACES[0] >= top) & (np.arange(N) // PLACES[0] < bottom))
    & ((np.arange(N) % PLACES[0] >= left) & (np.arange(N) % PLACES[0] < right))
    for top in range(PLACES[1])
    for bottom in range(top + 1, PLACES[1] + 1)
    for left in range(PLACES[0])
    for right in range(left + 1, PLACES[0] + 1)
]


def precision(rng: np.random.Generator) -> np.ndarray:
    half = rng.normal(0, 1, (N, N))
    return half @ half.T


def test_every_rectangle_once():
    found = {_rectangle(index).tobytes() for index in range(len(LABELS))}
    assert found == {label.tobytes() for label in LABELS}


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 999))
def test_sums_and_squares(seed):
    rng = np.random.default_rng(seed)
    a, b = precision(rng), rng.normal(0, 1, N)
    sums, squares = _sums(b), _squares(a)
    for index in rng.integers(0, len(LABELS), 50):
        label = _rectangle(int(index)).astype(float)
        np.testing.assert_allclose(sums[index], label @ b, atol=1e-9)
        np.testing.assert_allclose(squares[index], label @ a @ label, rtol=1e-9)


@settings(max_examples=10, deadline=None)
@given(index=st.integers(0, len(LABELS) - 1))
def test_a_rectangle_that_moved_is_found(index):
    """Or the rest of the places, where these are fewer; a row or a column more is another."""
    label = LABELS[index]
    if not 12 <= min(label.sum(), N - label.sum()) <= N // 2:
        return
    offsets = Normal(100.0 * np.eye(N), 100.0 * 1.0 * label, 0.0)
    (_, found, _), *_ = outlines([offsets], np.ones(N, bool))
    assert (found == label).all() or (found == ~label).all()


@pytest.mark.parametrize("wide", [3, 7, 10])
def test_either_side_of_an_outline_may_have_moved(wide):
    """The likelihood is the same, and most of an image moves rarely."""
    left = np.arange(N) % PLACES[0] < wide
    still = np.eye(N) - 1.0 / N  # an offset of all places is the rig's
    offsets = Normal(100.0 * still, 100.0 * still @ left, 0.0)
    found = outlines([offsets], np.ones(N, bool))
    prior = {label.tobytes(): log_prior for _, label, log_prior in found}
    assert len(prior) == len(found)
    smaller, larger = sorted([left, ~left], key=np.sum)
    assert prior[smaller.tobytes()] >= prior[larger.tobytes()]
    assert (prior[smaller.tobytes()] == pytest.approx(prior[larger.tobytes()])) == (wide == 7)
