"""Whatever a strategy does becomes a row; no table is lost."""

from dataclasses import dataclass, field, replace

from parts_of_repairs import _trial

from stereorecal.comparison import compare_scenes
from stereorecal.geometry import StereoRig
from stereorecal.matching import SAD
from stereorecal.objectives import Parameters
from stereorecal.recalibration import recalibrate_case
from stereorecal.scoring.host import Score
from stereorecal.strategies import AbstractStrategy, Budget, Need, Outcome, Status

SMALL = {"matcher": SAD(num_disparities=24), "draws": 2, "scale": 0.5, "budget": Budget(evaluations=5)}


@dataclass(frozen=True)
class Idle(AbstractStrategy):
    def run(self, objective, start, seed):
        objective.value(start)
        return Outcome(start, Status.STALLED, "it has no wish to move")


@dataclass(frozen=True)
class Inside(AbstractStrategy):
    """Works inside JAX: declares two points and what they cost, and asks for no value."""

    def run(self, objective, start, seed):
        objective.charge(150.0, start)
        objective.charge(200.0, start + 0.5)
        return Outcome(start, Status.CONVERGED)


@dataclass(frozen=True)
class Knows(AbstractStrategy):
    """Nominates the truth, which it may evaluate."""

    truth: StereoRig = field(compare=False)
    asks: bool

    def run(self, objective, start, seed):
        best = objective.images.chart.coordinates_of(self.truth)
        if self.asks:
            objective.value(best)
        return Outcome(best, Status.CONVERGED)


class Needy(Idle):
    needs = Need.RESIDUALS


def run(scene, strategies, **changes):
    given_scene = scene()
    return compare_scenes([given_scene], strategies=strategies, **(SMALL | changes))


def test_a_strategy_that_does_not_move_changes_nothing(scene):
    table = run(scene, {"idle": Idle()})
    for trial in table.trials:
        assert (trial.status, trial.message) == ("STALLED", "it has no wish to move")
        assert (trial.accepted, trial.reason) == (False, "not_improved")
        assert trial.score_final == trial.score_initial
        assert 0 < max(trial.rotation_error_deg.values()) <= 0.5 + 1e-9
    assert table.summary[0]["success_rate"] == 0.0


def test_counts_are_of_all_frames_even_of_those_that_a_repair_left_out(scene, monkeypatch):
    """Or r would compare a few frames with all."""
    given_scene, whole = scene("harbour", 0, (160, 120), 2), []

    def leaves_out(*arguments):
        solution = recalibrate_case(*arguments)
        whole.append(solution)
        half = Score(solution.score_before.count // 2, solution.score_before.pixels // 2)
        return replace(solution, used=(0,), score_before=half, score_after=half)

    monkeypatch.setattr(_trial, "recalibrate_case", leaves_out)
    table = compare_scenes([given_scene], strategies={"idle": Idle()}, **(SMALL | {"draws": 1}))
    assert [trial.score_initial for trial in table.trials] == [found.score_before.count for found in whole]
    assert [trial.score_final for trial in table.trials] == [found.score_before.count for found in whole]


def test_a_need_that_is_not_met_is_skipped_with_the_reason(scene):
    table = run(scene, {"needy": Needy(), "idle": Idle()})
    rows = {name: [t for t in table.trials if t.strategy == name] for name in ("needy", "idle")}
    assert {t.status for t in rows["needy"]} == {"SKIPPED"}
    assert all("needs least-squares residuals" in t.message for t in rows["needy"])
    assert {t.status for t in rows["idle"]} == {"STALLED"}
    summary = {row["strategy"]: row for row in table.summary}
    assert [summary["needy"][key] for key in ("skipped", "failed", "success_rate")] == [2, 0, None]


def test_points_declared_without_a_value_are_valued_for_the_marks(scene):
    given, task = scene(), SMALL | {"draws": 1, "budget": Budget(evaluations=2000)}
    table = compare_scenes([given], strategies={"inside": Inside(), "idle": Idle()}, **task)
    inside, idle = table.trials
    assert inside.score_at["100"] is None
    assert inside.score_at["300"] == idle.score_at["100"]  # both the start
    assert inside.score_at["1000"] != inside.score_at["300"]
    medians = {row["strategy"]: row["score_at_median"] for row in table.summary}
    assert medians["inside"] == inside.score_at


def test_a_point_nominated_without_a_value_is_valued_in_the_box_of_the_stage(scene):
    """Which is that of the priors, where some are given."""
    given, free = scene(), Parameters(priors={"yaw": 0.2})
    both = {"asks": Knows(given.rig, asks=True), "only nominates": Knows(given.rig, asks=False)}
    asks, nominates = compare_scenes([given], strategies=both, free=free, **(SMALL | {"draws": 1, "scale": 1.0})).trials
    assert nominates.score_at["100"] == asks.score_at["100"] > asks.score_initial


def test_a_broken_installed_strategy_fails_and_the_others_live(scene, install):
    install("stereorecal.strategies", {"shaky": "no_such_module:Thing"})
    table = run(scene, ["shaky", "compass"])
    rows = {name: [t for t in table.trials if t.strategy == name] for name in ("shaky", "compass")}
    assert {t.status for t in rows["shaky"]} == {"FAILED"}
    assert all("strategy shaky" in t.message and "cannot be loaded" in t.message for t in rows["shaky"])
    assert {t.status for t in rows["compass"]} == {"BUDGET"}


def test_budget_and_seed_reach_the_strategy(scene):
    @dataclass(frozen=True)
    class Curious(Idle):
        def run(self, objective, start, seed):
            return Outcome(start, Status.STALLED, f"{objective.budget.evaluations:g} {seed}")

    table = run(scene, {"curious": Curious()}, seed=7)
    assert [t.message for t in table.trials] == ["5 7", "5 8"]
