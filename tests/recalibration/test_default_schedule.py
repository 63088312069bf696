"""The default schedule end to end: the geometry comes right, and what is right or invisible is left alone."""

from dataclasses import dataclass, replace
from io import StringIO

import jax
import numpy as np
import pytest
from rich.console import Console

from stereorecal.geometry import StereoRig
from stereorecal.matching import SAD
from stereorecal.objectives import Reach, as_parameters
from stereorecal.recalibration import Case, Reason, Repair, Schedule, ScoreKind, Solution, Stage, recalibrate
from stereorecal.recalibration._initial_assessment import InitialAssessment, assess_initial_rig
from stereorecal.recalibration._recalibrate import search_stands
from stereorecal.recordings import Pair
from stereorecal.report.repair_tables import repairs_table
from stereorecal.scoring import pyramid
from stereorecal.strategies import AbstractStrategy, Budget, Need, Outcome, Status
from stereorecal.synthetic import decalibrate, default_rig, photographs, plan_drive

SAD_48 = SAD(num_disparities=48)  # which other files have compiled
RIG = default_rig().resized((320, 240))
FREE = [0, 1, 2, 4, 5]
UNITS = np.array([180 / np.pi] * 3 + [100 / RIG.baseline] * 2)  # degrees, percent of the baseline
DRIFT = (1.5, -1.0, -1.5, 0.5, -0.5)


def drifted(drift=DRIFT) -> StereoRig:
    """The truth, off by so many degrees and percent of the baseline."""
    return RIG.with_extrinsics(RIG.extrinsics + np.insert(np.array(drift) / UNITS, 3, 0.0))


def errors(rig: StereoRig) -> np.ndarray:
    """Distance from the truth: pitch, yaw, roll [degrees], y, z [percent of the baseline]."""
    return np.abs(np.asarray(rig.extrinsics) - RIG.extrinsics)[FREE] * UNITS


def repair(rig, pairs, **options) -> Solution:
    """Rendered rigs have the intrinsics that they say."""
    return recalibrate(rig, pairs, matcher=SAD_48, prior="exact", **options)


def assert_harmless(solution: Solution):
    """Accepted only if no axis that is said to be observed lies further off than before, by more than its interval."""
    assert (solution.rig is solution.initial) != solution.accepted
    if solution.accepted:
        assert solution.uncertainty is not None
        known = solution.uncertainty
        further = errors(solution.rig) - errors(solution.initial)
        assert (further <= known.interval)[known.observed].all()


@pytest.fixture(scope="module")
def harbour(scene):
    return scene("harbour", 0, RIG.left.size).pairs


@pytest.fixture(scope="module")
def repaired(harbour):
    return repair(drifted(), harbour)


def fog() -> Pair:
    flat = np.full((240, 320), 128.0, np.float32)
    flat[0, 0] = 129.0
    return Pair(flat, flat[::-1].copy())


def test_a_drifted_rig_comes_right(repaired):
    assert repaired.accepted
    assert repaired.reason is Reason.IMPROVED
    assert repaired.status is Status.CONVERGED
    pitch, yaw, roll, y, z = errors(repaired.rig)
    assert max(pitch, roll) < 0.01
    assert yaw < 0.05
    assert max(y, z) < 0.6
    assert (errors(repaired.rig) < 3 * repaired.uncertainty.interval).all()
    assert_harmless(repaired)


def test_what_it_says_about_itself(repaired):
    """Intervals of a size that means something; rows and counts before and after."""
    known, rows = repaired.uncertainty, repaired.row_errors
    assert known.observed[:4].all()  # y and z together are hardly told in images this small
    assert (known.interval[:3] < [0.02, 0.1, 0.02]).all()
    assert (known.interval > 1e-4).all()
    np.testing.assert_allclose(repaired.covariance, repaired.covariance.T, rtol=1e-9)
    assert rows.before > 2
    assert rows.after < 0.2
    assert rows.significance > 5
    assert repaired.score_after.count > 2 * repaired.score_before.count
    # The far points suffer most: the yaw was a degree off.
    wrong = repaired.depth_error_percent
    assert abs(wrong[5]) < abs(wrong[100])
    assert abs(wrong[10]) > 5


def test_x_and_the_given_rig_stay(repaired):
    np.testing.assert_array_equal(repaired.initial.extrinsics, drifted().extrinsics)
    assert repaired.rig.extrinsics[3] == RIG.extrinsics[3]
    assert repaired.rig is repaired.candidate


def test_text(repaired):
    lines = str(repaired).splitlines()
    assert lines[0] == f"accepted: {Reason.IMPROVED.value}"
    for when, line in (("before", lines[2]), ("after", lines[3])):
        assert line.startswith(when)
        assert line.endswith(f", row error {getattr(repaired.row_errors, when):.2f} px")
    axes = {line.split()[0]: line for line in lines[4:10]}
    assert list(axes) == ["pitch", "yaw", "roll", "x", "y", "z"]
    assert "±" not in axes.pop("x")
    percent = 10 * float(repaired.initial.baseline)  # of the baseline, in mm
    for (name, line), half_width in zip(axes.items(), repaired.uncertainty.interval, strict=True):
        in_unit = half_width if name in ("pitch", "yaw", "roll") else half_width * percent
        assert float(line.rpartition("± ")[2]) == pytest.approx(in_unit, abs=0.00051)
    assert lines[-1].startswith("depth was off: ")
    assert [part.rpartition(" at ")[2] for part in lines[-1].split(", ")] == ["5 B", "10 B", "30 B", "100 B"]


def test_what_the_candidate_changes(repaired):
    found = repaired.difference
    np.testing.assert_allclose(list(found.rotation_deg.values()), np.degrees(repaired.change[:3]))
    assert found.depth_error_percent == repaired.depth_error_percent
    assert found.columns[-1] == repaired.view.size[0] - 1
    # Over the whole view, not only where rows were measured.
    assert found.row_error_median == pytest.approx(repaired.row_errors.before, rel=0.5)


def test_covariance_is_in_the_units_of_differences(repaired):
    """Degrees and percent of the baseline, as conventions.md says."""
    half_widths = 1.96 * np.sqrt(np.diag(repaired.covariance))
    np.testing.assert_allclose(half_widths, repaired.uncertainty.interval)
    assert (errors(repaired.candidate) < 3 * half_widths).all()
    assert half_widths.max() < 1.5


def test_no_interval_of_what_was_rejected(repaired):
    rejected = replace(repaired, reason=Reason.CANNOT_TELL)
    assert "±" in str(repaired)
    assert "±" not in str(rejected)
    assert "depth was off" not in str(rejected)
    for solution, shown in ((repaired, True), (rejected, False)):
        page = StringIO()
        Console(width=120, file=page).print(repairs_table([Repair("harbour", solution).as_dict()], 120))
        assert ("±" in page.getvalue()) == shown


def test_stages(repaired):
    assert [stage.stage.scale for stage in repaired.stages] == [0.25, 0.5, 1.0]
    assert repaired.cost.budgeted == pytest.approx(sum(stage.cost for stage in repaired.stages))
    assert repaired.evaluations == sum(len(run.trace.values) for stage in repaired.stages for run in stage.runs)
    for stage in repaired.stages[1:]:
        # Each match is paid for; the solver's own work is next to nothing.
        matches = stage.matching_cost / stage.scale**2
        assert matches == pytest.approx(round(matches))
        assert 1 <= matches <= stage.stage.rounds
        assert stage.cost < stage.matching_cost + 0.5


def test_the_same_again(harbour, repaired):
    again = repair(drifted(), harbour)
    np.testing.assert_array_equal(again.candidate.extrinsics, repaired.candidate.extrinsics)
    np.testing.assert_array_equal(again.covariance, repaired.covariance)
    assert again.score_after == repaired.score_after
    assert again.cost == repaired.cost


def test_what_is_right_is_left_alone(harbour):
    solution = repair(RIG, harbour)
    assert solution.reason is Reason.ALREADY_GOOD
    assert solution.reason.healthy
    assert not solution.accepted
    assert solution.rig is solution.initial is RIG
    assert errors(solution.candidate)[[0, 2]].max() < 0.01
    assert "the initial calibration stays" in str(solution)
    assert "depth was off" not in str(solution)


def test_what_was_repaired_is_left_alone(harbour, repaired):
    assert repair(repaired.rig, harbour).reason is Reason.ALREADY_GOOD


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("drift", [DRIFT, (0.0, 1.5, 0.0, 0.0, 0.0)])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_open_sea_never_does_harm(scene, drift, seed):
    assert_harmless(repair(drifted(drift), scene("open-sea", seed, RIG.left.size).pairs))


def test_fog():
    solution = repair(drifted(), [fog()])
    assert solution.reason is Reason.TOO_LITTLE_TEXTURE
    assert solution.status is Status.NO_SIGNAL
    assert solution.rig is solution.initial
    assert solution.row_errors is solution.uncertainty is solution.covariance is None
    assert solution.score_after.count == 0
    assert "±" not in str(solution)


def test_a_drift_far_beyond_the_reach(harbour):
    """The images have texture: it is no night or fog, and worth an alarm."""
    far = drifted((12.0, 0.0, 0.0, 0.0, 0.0))
    solution = repair(far, harbour)
    assert solution.reason is Reason.NO_MATCHES
    assert solution.rig is far


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("limit", [0.01, 5, 20, 36])
def test_a_budget_is_kept(harbour, repaired, limit):
    """Whatever of the schedule fits; without a look at the rows nothing is accepted."""
    solution = repair(drifted(), harbour, budget=Budget(evaluations=limit))
    assert solution.cost.budgeted <= limit * (1 + 1e-9)
    assert_harmless(solution)
    if all(stage.found is None for stage in solution.stages):
        assert solution.reason is Reason.OUT_OF_BUDGET
        assert solution.status is Status.BUDGET
        assert not solution.accepted
    elif repaired.cost.budgeted > limit:
        runs, all_runs = (sum(len(stage.runs) for stage in one.stages) for one in (solution, repaired))
        assert runs < all_runs
    assert len(solution.stages) <= 3


def test_a_cut_budget_does_not_fall_back_on_the_count(scene):
    """The count gains a lot, but it knows too little of yaw to be trusted alone."""
    rig, street = drifted((0.3, 0.0, 0.0, 0.0, 0.0)), scene("street", 0, RIG.left.size).pairs
    solution = repair(rig, street, budget=Budget(evaluations=5))
    assert solution.score_after.count > 1.02 * solution.score_before.count
    assert solution.reason is Reason.OUT_OF_BUDGET
    assert solution.rig is rig
    assert not solution.reason.healthy


def test_frames_are_repaired_jointly_and_fog_among_them_does_not_matter(scene, harbour):
    """Two frames of the rig, or one and another that shows nothing. From near by, and one stage: less to compile."""
    schedule = Schedule("rows", Schedule.default().stages[2:])
    for pairs in ([*harbour, *scene("harbour", 1, RIG.left.size).pairs], [*harbour, fog()]):
        solution = repair(drifted((0.2, -0.3, -0.2, 0.0, 0.0)), pairs, schedule=schedule)
        assert solution.reason is Reason.IMPROVED
        assert solution.stages[-1].found.weight.shape[0] == 2
        assert solution.score_after.pixels == 2 * 320 * 240
        pitch, yaw, roll, *_ = errors(solution.rig)
        assert max(pitch, roll) < 0.01
        assert yaw < 2.0 * solution.uncertainty.interval[1] < 0.15
        assert (errors(solution.rig) < 3 * solution.uncertainty.interval).all()


@dataclass(frozen=True)
class Lost(AbstractStrategy):
    """Ends far from where it starts, where nothing matches."""

    needs = Need.RESIDUALS

    def run(self, objective, start, seed):
        return Outcome(np.full(objective.dim, 0.9), Status.STALLED)


def test_a_look_repairs_where_a_search_got_lost(harbour):
    schedule = Schedule("lost", (Stage(Lost(), score=ScoreKind.EPIPOLAR),))
    solution = repair(drifted((0.1, 0.0, -0.1, 0.0, 0.0)), harbour, schedule=schedule)
    assert solution.reason is Reason.IMPROVED
    assert errors(solution.rig)[[0, 2]].max() < 0.01


def test_a_look_repairs_nothing_where_a_search_saw_more_and_doubts(harbour):
    """Two fifths of the image moved: what matches at the start is of one part, and fits a rig."""
    (pair,) = harbour
    right = pair.right.copy()
    right[144:] = np.roll(pair.right, 3, axis=0)[144:]
    assert not repair(drifted((0.2, 0.0, -0.2, 0.0, 0.0)), Pair(pair.left, right)).accepted


@pytest.fixture(scope="module")
def case(harbour) -> Case:
    return Case(pyramid(drifted((0.2, -0.3, -0.2, 0.0, 0.0)), harbour), SAD_48, Reach(), as_parameters(None))


@pytest.fixture(scope="module")
def look(case) -> InitialAssessment:
    return assess_initial_rig(case, Schedule.default().stages[-1])


def that_leaves(look: InitialAssessment, rows: float) -> InitialAssessment:
    """The same with a candidate of this row error."""
    decision = look.answer.decision
    said = np.stack([decision.rows_px[0], decision.rows_px[1] * rows / decision.rows_px[1, 0]])
    return replace(look, answer=replace(look.answer, decision=replace(decision, rows_px=said)))


@pytest.mark.parametrize("row_error", [0.1, 0.6])
def test_a_look_is_sure_only_of_rows_that_align(look, row_error):
    """Through a rig that is far off it sees what fits by chance, which leaves epipolar errors."""
    assert that_leaves(look, row_error).repairs == (row_error < 0.3)


@pytest.mark.parametrize(
    ("by_search", "by_look", "stands"), [(0.1, 0.05, True), (0.5, 0.1, False), (0.4, 0.6, True), (0.6, 0.4, False)]
)
def test_a_repair_of_the_search_goes_before_one_of_a_look_that_leaves_more(case, look, by_search, by_look, stands):
    """Or, if it explains the rows, before any."""
    ending = that_leaves(look, by_search).ending(case)
    assert ending.reason is Reason.IMPROVED
    assert search_stands(ending, (), that_leaves(look, by_look)) == stands


@pytest.mark.slow
def test_a_late_shutter_is_told_from_a_drift_though_neither_leaves_good_rows():
    plan = plan_drive("street", 0, 25, weather=False, late=((0, 25, 0.6),))
    pairs = list(photographs(plan))[::3]
    found = recalibrate(drifted((0.2, 0.2, -0.2, 0.0, 0.0)), pairs, motion=True).estimate
    assert found.delay.probability > 0.9
    assert found.delay.seconds == pytest.approx(0.2, abs=0.05)  # of the time between two pairs


@pytest.mark.slow
def test_what_a_late_shutter_leaves_frees_no_intrinsics():
    """Lenses would explain some of it, also in frames that are left out."""
    plan = plan_drive("street", 1, 25, weather=False, late=((0, 25, 0.6),))
    plan = replace(plan, rig=plan.rig.resized((640, 480)))
    given = decalibrate(plan.truth(12), jax.random.key(1), 0.3, 0.0027)
    found = recalibrate(given, list(photographs(plan))[::3], motion=True)
    assert found.estimate.is_late
    assert found.intrinsics is None
    assert found.reason is Reason.LATE_SHUTTER
    assert found.misfit.cause.name == "LATE"
    assert "trigger both cameras at once" in str(found)
