"""The field's table: whatever a method does is a row, truth is a column, and nothing finished is done twice."""

import base64
import hashlib
import json
import re
from concurrent.futures import CancelledError, Executor, Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from stereorecal_field.judges import AbstractRecipe, Case, Draws, Judgement
from stereorecal_field.table import (
    ACCEPTED,
    GOOD,
    REFUSED,
    AbstractMethod,
    Answer,
    Field,
    FieldTrial,
    Library,
    Strategy,
    _field_trial,
    as_trial,
    compare_field,
    methods_of,
    planned,
)

import stereorecal as sr
from stereorecal.strategies import AbstractStrategy, Need, NeedNotMet, Outcome, Status

RIG = sr.synthetic.default_rig().resized((160, 120))
PAIR = sr.Pair(*np.random.default_rng(0).uniform(0, 255, (2, 120, 160)).astype(np.float32))


class NoMemory:
    """In place of PeakMemory, which cleans up first: slow, where nothing is measured."""

    mebibytes = 1.0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass


@pytest.fixture(scope="module", autouse=True)
def quick():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_field_trial, "PeakMemory", NoMemory)
        yield


def judge_by_yaw(rig: sr.StereoRig) -> Judgement:
    """Rows are |pitch| in minutes, depth at 30 baselines is yaw in minutes."""
    pitch, yaw, _ = 60 * np.degrees(rig.extrinsics[:3] - RIG.extrinsics[:3])
    return Judgement(
        abs(pitch), {10: yaw / 3, 30: yaw if abs(yaw) < 60 else np.inf}, {"pitch": 0, "yaw": yaw, "roll": 0}
    )


@dataclass(frozen=True)
class Made(AbstractRecipe):
    judge: ClassVar[str] = "rendered"
    judged_by: ClassVar[str] = "by what the test says"

    def make(self) -> Case:
        return Case(turned(pitch=1, yaw=4), (PAIR,), "exact", judge_by_yaw)


def turned(pitch: float, yaw: float) -> sr.StereoRig:
    """By minutes."""
    return RIG.with_extrinsics(RIG.extrinsics + np.radians([pitch / 60, yaw / 60, 0, 0, 0, 0]))


@dataclass(frozen=True)
class Fixed(AbstractMethod):
    """Says what it was made to say."""

    answer: Answer | Exception

    @property
    def origin(self) -> str:
        return "tests"

    def solve(self, case, matcher, reach, seed) -> Answer:
        if isinstance(self.answer, BaseException):
            raise self.answer
        return self.answer


def methods() -> tuple[AbstractMethod, ...]:
    return (
        Fixed("right", Answer(turned(0, 0), ACCEPTED, "found it", (-1.0, 1.0))),
        Fixed("proud", Answer(turned(0, 3), ACCEPTED, "found it", (-1.0, 1.0))),
        Fixed("rows only", Answer(turned(0, 40), ACCEPTED, "rows are aligned")),
        Fixed("beyond", Answer(turned(0, 100), ACCEPTED, "far")),
        Fixed("shy", Answer(turned(1, 4), REFUSED, "cannot tell")),
        Fixed("content", Answer(turned(1, 4), GOOD, "already good", (0.0, 9.0))),
        Fixed("needy", NeedNotMet("it needs more.")),
        Fixed("broken", KeyError("a <bug>")),
    )


def table(recipes=2, **options) -> Field:
    draws = Draws(number=recipes)
    made = [Made("scene", draw, 0, 0.5, 0.01) for draw in range(recipes)]
    empty, tasks = planned(["rendered"], made, methods(), matcher=None, draws=draws, reach=None)
    return compare_field(empty, tasks, **options)


@pytest.fixture(scope="module")
def field() -> Field:
    return table()


def test_whatever_a_method_does_is_a_row(field):
    rows = {row.method: row for row in field.summary}
    assert {name: (row.accepted, row.good, row.refused, row.skipped, row.failed) for name, row in rows.items()} == {
        "right": (2, 0, 0, 0, 0),
        "proud": (2, 0, 0, 0, 0),
        "rows only": (2, 0, 0, 0, 0),
        "beyond": (2, 0, 0, 0, 0),
        "shy": (0, 0, 2, 0, 0),
        "content": (0, 2, 0, 0, 0),
        "needy": (0, 0, 0, 2, 0),
        "broken": (0, 0, 0, 0, 2),
    }
    assert rows["broken"].trials == 2
    assert rows["needy"].trials == 0
    assert not field.interrupted


def test_harm_is_what_truth_says(field):
    """Rows that are aligned do not help whose depth is worse; what was not accepted harms nobody."""
    assert {row.method for row in field.summary if row.harmful} == {"rows only", "beyond"}
    rows = {row.method: row for row in field.summary}
    assert rows["rows only"].depth_error_percent["final"]["30"] == pytest.approx(40.0)
    assert rows["shy"].row_error_px == pytest.approx({"start": 1.0, "final": 1.0})
    assert np.isinf(rows["beyond"].depth_error_percent["final"]["30"])


def test_coverage_counts_who_states_something(field):
    stated = {row.method: (row.covered, row.stated) for row in field.summary if row.stated}
    assert stated == {"right": (2, 2), "proud": (0, 2), "content": (2, 2)}


def test_json_is_strict_and_comes_back(field):
    data = json.loads(json.dumps(field.as_dict(), allow_nan=False))
    assert data["schema"] == "stereorecal.field/1"
    assert data["methods"][0] == {"name": "right", "changes": "pitch, yaw, roll, y, z", "origin": "tests"}
    assert data["judges"] == {"rendered": "by what the test says"}
    assert data["settings"]["matcher"]["origin"].startswith("stereorecal ")  # another version begins anew
    assert [as_trial(row) for row in data["trials"]] == list(field.trials)


def test_the_page_sorts_shows_and_escapes(field):
    pytest.importorskip("matplotlib", reason="it is not installed")
    from stereorecal_field.table._field_page import field_page

    page = field_page(field.as_dict())
    (script,) = re.findall(r"<script>(.*?)</script>", page, re.S)
    assert base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() in page
    assert 'class="sorts"' in page
    assert page.count("<svg") == 3
    assert "rows of lidar and of drives in folders: those are of images that methods get" in page
    assert "Seconds hold compilation" in page
    assert "broken</b> failed, 2 trials: &#39;a &lt;bug&gt;&#39;" in page
    assert "<bug>" not in page
    assert 'data-value="1e99">4.0, ∞</td>' in page
    assert "2 of 2" in page


def test_a_page_of_nothing_but_trouble():
    pytest.importorskip("matplotlib", reason="it is not installed")
    from stereorecal_field.table._field_page import field_page

    draws = Draws(number=1)
    empty, tasks = planned(
        ["rendered"], [Made("s", 0, 0, 0.5, 0.01)], methods()[-2:], matcher=None, draws=draws, reach=None
    )
    for found in (empty, compare_field(empty, tasks)):
        assert "</html>" in field_page(found.as_dict())


def test_what_is_finished_is_not_done_again():
    first = table(1)
    known = {trial.key: replace(trial, message="from before") for trial in first.trials[:5]}
    saved: list[Field] = []
    steps = []
    again = table(1, done=known, on_trial=saved.append, progress=lambda *step: steps.append(step))
    assert [trial.message for trial in again.trials[:5]] == ["from before"] * 5
    assert [len(so_far.trials) for so_far in saved] == [6, 7, 8]
    assert [so_far.interrupted for so_far in saved] == [True, True, False]
    assert steps[0] == (5, 8)
    assert steps[-1] == (8, 8)
    assert [trial.method for trial in again.trials] == [method.name for method in methods()]


def test_trials_of_other_tables_are_left_out():
    stranger = FieldTrial("x", "rendered", "x", 0, "x", "failed", "x")
    assert all(trial.key != "x" for trial in table(1, done={"x": stranger}).trials)


def test_ctrl_c_keeps_what_is_finished():
    def stop(so_far):
        if so_far.trials[-1].method == "beyond":
            raise KeyboardInterrupt

    found = table(1, on_trial=stop)
    assert found.interrupted
    assert [trial.method for trial in found.trials] == ["right", "proud", "rows only", "beyond"]


class Lossy(Executor):
    """Its workers die, or it is shut down, at the third trial."""

    def __init__(self, error: Exception):
        self.error, self.begun = error, 0

    def submit(self, fn, /, *args, **kwargs):
        self.begun += 1
        future = Future()
        if self.begun < 3:
            future.set_result(fn(*args, **kwargs))
        else:
            future.set_exception(self.error)
        return future


@pytest.mark.parametrize("error", [BrokenProcessPool("a process died"), CancelledError("shut down")])
def test_a_trial_whose_worker_died_is_missing_and_not_failed(error):
    saved, told = [], []
    found = table(1, executor=Lossy(error), on_trial=saved.append, on_loss=told.append)
    assert found.interrupted
    assert (
        {trial.method for trial in found.trials} == {"right", "proud"} == {trial.method for trial in saved[-1].trials}
    )
    assert told == [error]


def test_nothing_to_do_and_names_twice():
    with pytest.raises(sr.InputError, match="nothing to compare"):
        planned([], [], methods(), matcher=None, draws=Draws(), reach=None)
    one = Made("s", 0, 0, 0.5, 0.01)
    with pytest.raises(sr.InputError, match="same name"):
        planned([], [one, one], methods(), matcher=None, draws=Draws(), reach=None)


def test_names_of_methods():
    assert [method.name for method in methods_of(["rows", "compass"])] == ["rows", "compass"]
    assert isinstance(methods_of(["count"])[0], Library)
    assert [method.name for method in methods_of(None)][:3] == ["count", "rows", "motion"]
    with pytest.raises(sr.InputError, match="unknown method 'motoin'; did you mean motion"):
        methods_of(["motoin"])
    with pytest.raises(sr.InputError, match="named twice"):
        methods_of(["rows", "rows"])


def test_motion_needs_times_and_depth_that_is_not_known():
    for case, message in (
        (Made("s", 0, 0, 0, 0).make(), "exact"),
        (replace(Made("s", 0, 0, 0, 0).make(), prior="default"), "times"),
    ):
        with pytest.raises(NeedNotMet, match=message):
            Library("motion").solve(case, sr.SAD(), sr.Reach(), 0)


@dataclass(frozen=True)
class Nominating(AbstractStrategy):
    """Nominates what it was told."""

    needs: ClassVar[Need] = Need.IMAGES
    best: float = 0.5
    status: Status = Status.CONVERGED

    def run(self, objective, start, seed):
        return Outcome(np.full(objective.dim, self.best), self.status, "so it is")


def test_a_strategy_answers_for_itself():
    case = Made("s", 0, 0, 0, 0).make()
    good = Strategy("mine", Nominating()).solve(case, sr.SAD(), sr.Reach(3.0, 0.03), 0)
    assert good.status == ACCEPTED
    assert np.degrees(good.rig.extrinsics[1] - case.start.extrinsics[1]) == pytest.approx(1.5)
    stalled = Strategy("mine", Nominating(status=Status.STALLED)).solve(case, sr.SAD(), sr.Reach(), 0)
    assert (stalled.status, stalled.rig, stalled.message) == (REFUSED, case.start, "so it is")
    outside = [Strategy("mine", Nominating(best=2.0))]
    (row,) = compare_field(
        *planned([], [Made("s", 0, 0, 0, 0)], outside, matcher=None, draws=Draws(), reach=None)
    ).trials
    assert row.status == "failed"
    assert "nominated no point of the unit box" in row.message
