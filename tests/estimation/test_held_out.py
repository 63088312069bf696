"""What the rest of the images says of a part, in closed form against estimates from the rest alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from parts_of_estimates import Groups, first_of_same, parts_of

from stereorecal.estimation import PLACES, estimate
from stereorecal.objectives import BASELINE

DRIFT = (0.3, 0.2, -0.4, 0.2, -0.3)


def shown(disparity) -> Groups:
    """Groups of frames (f, p) that show these disparities, at as many places; each is the first of its own."""
    frames, size = np.shape(disparity)
    rays, one = np.tile([0.0, 0.0, 1.0], (frames * size, 1)), np.ones(frames * size)
    frame, place = np.repeat(np.arange(frames), size), np.tile(np.arange(size), frames)
    told = (0.0 * one, one, frame, place, np.ravel(disparity), one.astype(int))
    return Groups(rays, rays, *told, 500.0, one, np.arange(frames))


@given(places=st.lists(st.integers(0, 5), min_size=1, max_size=9), seed=st.integers(0, 99))
def test_parts_of_a_kind_are_all_of_the_view_each_once(places, seed):
    """Columns, rows, and frames, those that show the same in the same part."""
    groups = shown(20.0 * np.array(places)[:, None] + np.zeros((len(places), int(np.prod(PLACES)))))
    first = first_of_same(groups)
    assert [places[one] for one in first] == places
    assert len(set(first)) == len(set(places))
    groups = replace(groups, frame=first[groups.frame], first=first)
    groups = groups.of(np.random.default_rng(seed).random(len(groups)) < 0.7)
    kinds: dict[str, list[np.ndarray]] = {}
    for name, inside in parts_of(groups):
        kinds.setdefault(name.split()[0], []).append(inside)
    assert set(kinds) == ({"columns", "rows", "frames"} if len(set(places)) > 1 else {"columns", "rows"})
    for parts in kinds.values():
        np.testing.assert_array_equal(np.sum(parts, axis=0), 1)
    for part in kinds.get("frames", []):
        within = [set(np.unique(groups.frame[inside])) for inside in (part, ~part)]
        assert not {places[frame] for frame in within[0]} & {places[frame] for frame in within[1]}
    assert len(kinds["columns"]) == len(kinds["rows"]) == 3


def test_frames_show_the_same_if_half_of_it_stays():
    """Whatever passes near."""
    still = np.full(int(np.prod(PLACES)), 10.0)
    passed, most = still.copy(), still.copy()
    passed[: round(0.4 * len(still))] += 30.0
    most[: round(0.6 * len(still))] += 30.0
    assert first_of_same(shown([still, passed])).tolist() == [0, 0]
    assert first_of_same(shown([still, most])).tolist() == [0, 1]


def test_estimates_from_the_rest_say_the_same(rig, chart, prior, seen):
    """To two per cent of the rows that the part had, and most to a few per cent of those that are left."""
    left = prior.roots[1] @ np.random.default_rng(1).normal(size=chart.dim)
    true = chart.rig_at(left + np.r_[DRIFT, np.zeros(chart.dim - 5)])
    found, free = seen(rig, true, 1, frames=2, cells=1250), [name for name in chart.names if name != BASELINE]
    whole = estimate(found, rig, prior)
    x, y = np.moveaxis(np.asarray(rig.left.project(np.asarray(found.left, float))), -1, 0)
    place = (y * PLACES[1] / 480).astype(int) * PLACES[0] + (x * PLACES[0] / 640).astype(int)
    held_out, ratios = whole.held_out(free), []
    parts = list(parts_of(whole.shown))
    assert [part.name for part in held_out] == [name for name, _ in parts]
    for part, (name, inside) in zip(held_out, parts, strict=True):
        of_frames = name.startswith("frames")
        number, key = (np.arange(2)[:, None], "frame") if of_frames else (place, "place")
        outside = ~np.isin(number, getattr(whole.shown, key)[inside])
        rest = estimate(replace(found, weight=found.weight * outside), rig, prior)

        def rows(theta, inside=inside) -> float:
            each = np.abs(whole.shown.differences(chart, theta))
            return float(np.average(each[inside], weights=whole.shown.count[inside]))

        after = rows(rest.with_free(free))
        assert part.count == whole.shown.count[inside].sum()
        assert part.before == pytest.approx(rows(np.zeros(chart.dim)))
        assert part.fitted == pytest.approx(rows(whole.with_free(free)), abs=0.01)
        assert part.after == pytest.approx(after, abs=0.02 * part.before)
        ratios.append(part.after / after)
    assert np.median(np.abs(np.array(ratios) - 1.0)) < 0.08


def test_a_part_that_moved_is_not_predicted(rig, chart, seen):
    """Though the estimate knows of it, and the rest does: what moved is no excuse for the candidate."""
    found = seen(rig, chart.rig_at(np.r_[DRIFT, np.zeros(chart.dim - 5)]), cells=1500)
    right = np.array(found.right)
    right[..., 1] += np.float32(0.8 / 500) * (found.left[..., 0] > 0.25)
    parts = {part.name: part for part in estimate(replace(found, right=right), rig).held_out(chart.names[:5])}
    assert parts["columns 3 of 3"].after > 0.4
    assert max(parts[f"columns {number} of 3"].after for number in (1, 2)) < 0.25


def test_between_two_candidates_parts_see_what_lies_between(rig, chart, seen):
    found = estimate(seen(rig, chart.rig_at(np.r_[DRIFT, np.zeros(chart.dim - 5)]), cells=700), rig)
    each = (found.held_out(chart.names[:5], share) for share in (0.0, 1.0, 0.4))
    for kept, least, part in zip(*each, strict=True):
        assert part.after <= 0.6 * kept.after + 0.4 * least.after + 1e-9  # |rows| is convex
        assert part.before == kept.before == least.before
        assert kept.after != least.after
