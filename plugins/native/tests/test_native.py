"""The compiled search against its twins: the same integers as `winners_by_rows`, the same pixels as `reference.py`."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.matching import SAD, reference
from stereorecal.matching.sad._kernel import CALL, has_kernel, winners_by_kernel
from stereorecal.matching.sad._sad import _largest_cost, winners_by_rows
from stereorecal.matching.sad._stream import NEVER, Winners

if not has_kernel():
    WHY = "stereorecal-native is not installed; with a C++ compiler: pip install -e plugins/native"
    pytest.skip(WHY, allow_module_level=True)


def image_pair(seed: int, height: int, width: int, kind: str, cap: int) -> tuple[np.ndarray, np.ndarray]:
    """Two images as the search gets them, int16: from -cap to cap, or grey levels."""
    rng = np.random.default_rng(seed)
    lowest, highest = (-cap, cap) if cap else (0, 255)
    if kind == "flat":
        left = right = np.full((height, width), highest)
    elif kind == "as different as can be":
        left = rng.choice([lowest, highest], (height, width))
        right = lowest + highest - np.roll(left, -2, axis=1)
    else:
        left = rng.integers(lowest, highest + 1, (height, width))
        noise = rng.integers(-3, 4, (height, width)) if kind == "noisy" else 0
        right = np.clip(np.roll(left, -3, axis=1) + noise, lowest, highest)
    return left.astype(np.int16), right.astype(np.int16)


def by_kernel(left: np.ndarray, right: np.ndarray, options: SAD) -> Winners:
    return winners_by_kernel(jnp.asarray(left), jnp.asarray(right), options, _largest_cost(options))


def by_definition(left: np.ndarray, right: np.ndarray, options: SAD) -> Winners:
    """`Winners`, read off the costs of all candidates."""
    lowest, count = options.disparity_range(left.shape[1])
    left, right = left.astype(np.int64), right.astype(np.int64)
    costs = reference._cost_volume(left, right, lowest, count, options.block_size)
    index, winner = np.arange(count)[:, None, None], costs.argmin(axis=0)
    best = costs.min(axis=0)
    limit = best + best * options.uniqueness_ratio // 100
    rivals = ((costs <= limit) & (costs < NEVER) & (np.abs(index - winner) > 1)).sum(axis=0)

    def cost(wanted: int) -> np.ndarray:
        return np.where(index == winner + wanted, costs, NEVER).min(axis=0)

    mirrored = reference._cost_volume(right[:, ::-1], left[:, ::-1], lowest, count, options.block_size)
    from_right = mirrored.argmin(axis=0)[:, ::-1]
    return Winners(winner, best, np.where(best < NEVER, rivals, -1), cost(-1), cost(1), from_right)


def assert_same(found: Winners, expected: Winners) -> None:
    for name, here, there in zip(Winners._fields, found, expected, strict=True):
        np.testing.assert_array_equal(np.asarray(here), np.asarray(there), err_msg=name)


@st.composite
def searches(draw) -> tuple[SAD, tuple[int, int]]:
    """Options, and a size of images that they fit."""
    width, height = draw(st.integers(2, 90)), draw(st.integers(1, 24))
    lowest = draw(st.integers(-width + 1, width - 2))
    count = draw(st.integers(1, width - 1 - max(lowest, 0)))
    return (
        SAD(
            min_disparity=lowest,
            num_disparities=count,
            block_size=draw(st.sampled_from([3, 5, 11, 13, 27])),
            uniqueness_ratio=draw(st.sampled_from([0, 1, 15, 100])),
            pre_filter_cap=draw(st.sampled_from([0, 1, 31, 63])),
        ),
        (height, width),
    )


@settings(deadline=None, max_examples=3 * settings.default.max_examples)
@given(searches(), st.integers(0, 10**6), st.sampled_from(["plain", "noisy", "flat", "as different as can be"]))
def test_every_integer_is_that_of_the_definition(search, seed, kind):
    options, size = search
    pair = image_pair(seed, *size, kind, options.pre_filter_cap)
    assert_same(by_kernel(*pair, options), by_definition(*pair, options))


OPTIONS = [
    SAD(num_disparities=16),
    SAD(num_disparities=21, min_disparity=-9, uniqueness_ratio=0),
    SAD(num_disparities=35, min_disparity=4, disp12_max_diff=-1, block_size=3),
    SAD(num_disparities=2, pre_filter_cap=0, block_size=13),  # sums that int16 does not hold
    SAD(num_disparities=16, min_disparity=-30, uniqueness_ratio=100, block_size=31),
]


@pytest.mark.parametrize("options", OPTIONS)
def test_every_integer_is_that_of_the_twin_in_jax(options):
    twin = jax.jit(partial(winners_by_rows, options=options))
    for seed, kind in enumerate(["plain", "noisy", "flat", "as different as can be"]):
        pair = image_pair(seed, 37, 61, kind, options.pre_filter_cap)
        found, expected = by_kernel(*pair, options), twin(*pair)
        assert_same(found, expected if options.disp12_max_diff >= 0 else expected._replace(from_right=found.from_right))


@pytest.mark.parametrize("options", OPTIONS)
def test_the_matcher_finds_what_the_plain_twin_finds(options):
    rng = np.random.default_rng(0)
    left = rng.uniform(0, 255, (37, 61)).astype(np.float32)
    right = np.clip(np.roll(left, -3, axis=1) + rng.normal(0, 4, left.shape), 0, 255).astype(np.float32)
    assert options.custom_calls == (CALL,)
    assert CALL in jax.jit(options.match).lower(left, right).as_text()
    found, expected = options.match(left, right), reference.match(left, right, options)
    np.testing.assert_array_equal(np.asarray(found.valid), expected.valid)
    np.testing.assert_allclose(np.asarray(found.values), expected.values, atol=1e-4)


def test_a_batch_is_its_images_one_by_one():
    options = OPTIONS[1]
    pairs = [image_pair(seed, 20, 50, "noisy", 31) for seed in range(6)]
    lefts, rights = (np.stack(side).reshape(2, 3, 20, 50) for side in zip(*pairs, strict=True))
    search = partial(winners_by_kernel, options=options, largest_cost=_largest_cost(options))
    many = jax.jit(jax.vmap(jax.vmap(search)))(lefts, rights)
    for i, pair in enumerate(pairs):
        assert_same(Winners(*(leaf[divmod(i, 3)] for leaf in many)), by_definition(*pair, options))
    one_left = jax.vmap(search, in_axes=(None, 0))(jnp.asarray(lefts[0, 0]), rights[0])
    assert_same(Winners(*(leaf[2] for leaf in one_left)), by_definition(lefts[0, 0], rights[0, 2], options))


def test_threads_do_not_disturb_each_other():
    options, pairs = OPTIONS[0], [image_pair(seed, 40, 70, "noisy", 31) for seed in range(4)]
    alone = [by_kernel(*pair, options) for pair in pairs]
    with ThreadPoolExecutor(4) as pool:
        many = list(pool.map(lambda pair: by_kernel(*pair, options), pairs * 10))
    for found, expected in zip(many, alone * 10, strict=True):
        assert_same(found, expected)


def test_the_derivative_is_zero():
    """As that of the twin: a match does not change with the images, but for its sub-pixel part, which is not traced."""
    left, right = (image.astype(np.float32) + 100 for image in image_pair(0, 20, 50, "noisy", 31))
    matcher = OPTIONS[0]
    slope = jax.grad(lambda image: matcher.match(image, right).values.sum())(left)
    assert not np.asarray(slope).any()


@pytest.mark.parametrize(
    ("width", "count", "words"), [(39, 16, "not two images of one size"), (40, 40, "reach beyond the image")]
)
def test_what_would_read_beyond_the_images_is_refused(width, count, words):
    call = jax.ffi.ffi_call(CALL, [jax.ShapeDtypeStruct((9, 40), jnp.int32)] * 6)
    numbers = {"min_disparity": 0, "num_disparities": count, "block_size": 5, "uniqueness_ratio": 0, "largest_cost": 99}
    options = {name: np.int64(value) for name, value in numbers.items()}
    with pytest.raises(Exception, match=words):
        jax.block_until_ready(call(jnp.zeros((9, 40), jnp.int16), jnp.zeros((9, width), jnp.int16), **options))


PROGRAM = """
import sys, jax, numpy as np
jax.config.update("jax_compilation_cache_dir", sys.argv[1])
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
if sys.argv[2] == "without":
    sys.modules["stereorecal_native"] = None  # as one that cannot be loaded
from stereorecal import SAD
from stereorecal.scoring._rectify import Rectified
from stereorecal.scoring.host._disparities import match_in_blocks
rng = np.random.default_rng(0)
left = rng.uniform(0, 255, (60, 80)).astype(np.float32)
area = np.ones(left.shape, bool)
found = match_in_blocks(SAD(num_disparities=16), Rectified(left, np.roll(left, -5, axis=1), area, area))
print(int(found.valid.sum()), found.values[found.valid].astype(float).sum(), *SAD().custom_calls)
"""


def test_a_process_without_it_runs_nothing_that_one_with_it_has_cached(tmp_path):
    """Nor the other way round."""

    def told(how: str) -> tuple[list[str], str]:
        words = [sys.executable, "-c", PROGRAM, str(tmp_path), how]
        said = subprocess.run(words, capture_output=True, text=True, check=True)
        return said.stdout.split(), said.stderr

    (expected, quiet), (plain, warned) = told("with"), told("without")
    assert expected == [*plain, CALL]
    assert "is not used" in warned
    assert "is not used" not in quiet
    traced = set((tmp_path / "stereorecal").iterdir())
    assert len(traced) == 2
    assert [told(how)[0] for how in ("with", "without", "with")] == [expected, plain, expected]
    assert set((tmp_path / "stereorecal").iterdir()) == traced
