"""The promise of the library: a rig that drifted sees again as well as before, and measures again.

r is the paper's: the count after the repair over the count at the truth, both in the view of the start.
"""

import numpy as np
from hypothesis import Phase, example, given, settings, strategies as st
from simulated_rows import chart as chart, rig as rig, seen as seen

from stereorecal.decision import Verdict, decide
from stereorecal.estimation import estimate
from stereorecal.geometry import view
from stereorecal.matching import SAD
from stereorecal.recalibration import Reason, Schedule, difference, recalibrate
from stereorecal.scoring import row_differences
from stereorecal.scoring.host import score
from stereorecal.strategies import strategy

COMPASS = Schedule.count(strategy("compass"), scale=1.0)
MATCHER = SAD(num_disparities=48)  # which other files have compiled
component = st.floats(-1, 1)
AXES = ("pitch", "yaw", "roll", "y", "z")
FARTHEST = np.array([2.5, 2.5, 2.5, 2.25, 2.25])  # degrees; percent of the baseline


def drifted(rig, degrees, fraction, drift):
    """The rig moved by `drift`, five numbers in [-1, 1], of these limits."""
    limits = np.array([*[np.radians(degrees)] * 3, 0.0, *[fraction * rig.baseline] * 2])
    return rig.with_extrinsics(rig.extrinsics + limits * np.insert(drift, 3, 0.0))


# An example takes several seconds, so falsifying ones are not shrunk.
@settings(max_examples=4, phases=[Phase.explicit, Phase.generate])
@given(seed=st.integers(0, 2), drift=st.tuples(*[component] * 5))
def test_recovery(scene, seed, drift):
    given_scene = scene("harbour", seed)
    rig, matcher = given_scene.rig, SAD(num_disparities=24)
    start = drifted(rig, 0.3, 0.005, drift)
    solution = recalibrate(start, given_scene.pairs, schedule=COMPASS, matcher=matcher)
    reference = score(rig, given_scene.pairs, matcher=matcher, view=view(start))
    assert solution.score_after.count >= 0.95 * reference.count


BLINDS = 1.5  # pixels of row error, through which no matcher finds much
# Degrees of pitch, yaw, roll: some five times the median error of the benchmark (docs/accuracy.md), whose images are
# twice as large.
TOLERANCE = np.array([0.02, 0.1, 0.02])


@settings(max_examples=6, phases=[Phase.explicit, Phase.generate])
@given(
    kind=st.sampled_from([("harbour", 0), ("coast", 1), ("street", 1)]),
    size=st.sampled_from([0.0, 0.2, 1.0]),
    drift=st.tuples(*[component] * 5),
)
def test_a_drifted_rig_comes_back_and_an_undrifted_one_stays(scene, kind, size, drift):
    """By default, from anywhere within ±2.5° and ±2.25 %. Intrinsics may take up some of a drift, but rows and depth
    come right."""
    given_scene = scene(*kind, (320, 240))
    rig = given_scene.rig
    start = drifted(rig, 2.5 * size, 0.0225 * size, drift)
    solution = recalibrate(start, given_scene.pairs, matcher=MATCHER)
    left = difference(solution.rig, rig, view=solution.view)
    assert solution.reason.healthy
    if size == 0.0:
        assert solution.rig is start
    assert left.row_error_median < 0.15
    assert abs(left.depth_error_percent[10]) < 4.0


@settings(max_examples=4, phases=[Phase.explicit, Phase.generate])
@given(seed=st.integers(0, 2), drift=st.tuples(*[component] * 5))
def test_recovery_of_the_geometry(scene, seed, drift):
    """From anywhere within ±2.5° and ±2.25 %; an axis that the solution reports as not determined may be as far off as
    three of its own intervals."""
    given_scene = scene("harbour", seed, (320, 240))
    rig = given_scene.rig
    start = drifted(rig, 2.5, 0.0225, drift)
    solution = recalibrate(start, given_scene.pairs, matcher=MATCHER, prior="exact")
    error = np.abs(np.degrees(solution.rig.extrinsics[:3] - rig.extrinsics[:3]))
    known = solution.uncertainty
    assert known is not None
    assert solution.reason is Reason.IMPROVED or error.max() < 0.3
    allowed = np.where(known.observed[:3], TOLERANCE, np.maximum(TOLERANCE, 3.0 * known.interval[:3]))
    assert (error <= allowed).all(), (error, allowed)


@settings(max_examples=max(4, settings.default.max_examples // 4))
@given(
    seed=st.integers(0, 999),
    axis=st.sampled_from(np.eye(5).tolist()) | st.tuples(*[component] * 5),
    size=st.floats(-1.0, 1.0),
)
@example(seed=0, axis=[0.0, 0.0, 0.0, 1.0, 0.0], size=1.0)
def test_any_decalibration_is_recovered_from_its_rows(rig, chart, seen, seed, axis, size):
    """Of one axis, and of any mixture of them, without images: rows are aligned at every distance, rotations are held
    by their intervals, and whatever blinds the matcher is repaired, unless it is a shift alone: an image that is late
    has the same rows, and keeps a probability of a percent or two. A drift of z alone may stay within the noise of
    rows, which then say nothing of it."""
    drift = size * FARTHEST * axis
    true = chart.rig_at(np.r_[drift, np.zeros(chart.dim - 5)])
    found = estimate(seen(rig, true, seed), rig, "exact")
    without_noise = seen(found.chart.rig_at(found.theta), true, seed + 1, noise=0.0)
    rows = row_differences(without_noise, found.chart.rig_at(found.theta).extrinsics)[without_noise.weight > 0]
    assert np.sqrt(np.mean(rows**2)) < 0.05
    sigma = np.sqrt(np.diag(found.posterior.covariance))[:3]
    assert (np.abs(found.theta[:3] - drift[:3]) < 5.0 * sigma + 1e-3).all()
    said = decide(found, AXES)
    if said.rows_px[0, 0] > BLINDS:
        late = not np.any(drift[:3]) and 1.0 - said.better < 0.03
        assert said.verdict is Verdict.REPAIR or late
    if said.verdict is Verdict.REPAIR:
        assert (np.abs(said.theta[:3] - drift[:3]) < TOLERANCE).all()
