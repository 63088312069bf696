"""The paper's experiments: what they look at, that rows are right, that an interrupted run continues."""

import json
import subprocess
import sys
import weakref
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from json_page import differences
from machine import full_disk
from stereorecal_paper import (
    EXPERIMENTS,
    Extent,
    experiment_figures,
    methods,
    reproduce,
    save_calibrations,
    save_mission,
    synthetic_log,
    write_files,
)
from stereorecal_paper._pixel_counter import unstarred

import stereorecal as sr
from stereorecal import InputError
from stereorecal.io import load_log
from stereorecal.recordings import LazyPairs, Log, Mission, Pair
from stereorecal.scoring.host import with_disparity_range

TINY = Extent(images=1, starts=2, sweeps=1, points=7, matchers=(sr.SAD(), sr.BM()), steps=2, iterations=3)
COUNT = {"schedules": ("count",), "extent": TINY}


def turned(rig, *degrees):
    return rig.with_extrinsics(rig.extrinsics + np.array([*np.radians(degrees), 0.0, 0.0, 0.0]))


@pytest.fixture(scope="module")
def log(scene, tmp_path_factory) -> Log:
    """Two sequences of two pairs, three calibrations; on the disk, as all logs are."""
    folder = tmp_path_factory.mktemp("log")
    rig = scene().rig
    calibrations = {"2020-01-01": rig, "2020-02-01": turned(rig, 1.0, 0.2, 0.0), "2020-03-01": turned(rig, 0, 0, 1.2)}
    save_calibrations(calibrations, folder)
    for name, kind in (("2020-01-02-a", "harbour"), ("2020-01-03-b", "coast")):
        pairs = scene(kind, frames=2).pairs
        named = tuple(replace(pair, name=f"{index}.png") for index, pair in enumerate(pairs, 1))
        save_mission(Mission(name, "2020-01-01", named, frozenset({"2.png"}), rig), folder)
    return load_log(folder)


@pytest.fixture(scope="module")
def serial(log):
    return reproduce(log, **COUNT)


def timeless(found):
    """All rows, but for the time that they took."""

    def strip(value):
        if isinstance(value, dict):
            return {key: strip(item) for key, item in value.items() if key != "seconds"}
        return [strip(item) for item in value] if isinstance(value, list | tuple) else value

    return strip(found.as_dict()["rows"])


def test_every_experiment_has_its_rows(serial):
    assert serial.errors == {}
    assert serial.unfinished == 0
    number = {name: len(rows) for name, rows in serial.rows.items()}
    assert number == {"validity": 4, "sweeps": 10, "repair": 2, "generalise": 2, "ex_nihilo": 2, "sequential": 3}


def test_its_json_is_that_of_the_page(serial):
    """But for what the rows of each experiment hold, which is in their CSV files too."""
    told = {**serial.as_dict(), "summary": None, "rows": None, "errors": {"repair:1": "why"}}
    assert differences([told]) == (set(), set())


def test_validity_counts_each_pair_under_each_calibration(serial):
    row = serial.rows["validity"][0]
    assert list(row["counts"]) == ["2020-01-01", "2020-02-01", "2020-03-01"]
    assert max(row["counts"], key=row["counts"].get) == row["own"] == "2020-01-01"
    assert [r["starred"] for r in serial.rows["validity"]] == [False, True, False, True]


def test_a_repair_is_one_by_the_library_itself(log, serial):
    """N_i, N_o, N_GT and the errors of a row, computed again through the public functions."""
    row = serial.rows["ex_nihilo"][0]
    mission = log.missions[0]
    rig = log.calibration_of(mission)
    baseline = np.mean([float(c.baseline) for c in log.calibrations.values()])
    start = rig.with_extrinsics(np.array([0, 0, 0, -baseline, 0, 0]))
    np.testing.assert_allclose(row["extrinsics"]["start"], start.extrinsics)
    view = sr.view(rig.with_extrinsics(np.array([0, 0, 0, -float(rig.baseline), 0, 0])))
    found = rig.with_extrinsics(np.array(row["extrinsics"]["found"]))
    ranged = with_disparity_range(sr.SAD(), rig, unstarred(mission), view, np.radians(sr.Reach().degrees))
    for one, key in ((start, "score_initial"), (found, "score_final"), (rig, "score_reference")):
        assert sr.score(one, mission.pairs[:1], matcher=ranged, view=view).count == row[key]
    error = np.degrees(np.abs(found.extrinsics - rig.extrinsics)[:3])
    np.testing.assert_allclose(list(row["rotation_error_deg"].values()), error, atol=1e-9)
    assert row["score_initial"] < row["score_final"]
    way = row["way"]
    assert (way[0]["count"], way[-1]["count"]) == (row["score_initial"], row["score_final"])
    assert way[0]["rotation2"] == pytest.approx(np.sum(np.degrees(rig.extrinsics[:3]) ** 2))


def test_a_repair_climbs_in_the_view_in_which_it_is_judged(serial):
    """Whatever the wrong calibration: the count that compass climbs is the one that is judged."""
    for row in serial.rows["repair"]:
        assert row["accepted"] == (row["score_final"] > row["score_initial"])
        assert [point["count"] for point in row["way"]] == sorted(point["count"] for point in row["way"])


def test_sweeps_pass_through_the_reference(serial):
    for row in serial.rows["sweeps"]:
        middle = len(row["offsets"]) // 2
        assert row["offsets"][middle] == 0.0
        assert len(row["counts"]) == len(row["offsets"]) == 7
    pitch = next(r for r in serial.rows["sweeps"] if (r["axis"], r["matcher"]) == ("pitch", "sad"))
    assert max(pitch["counts"]) == pitch["counts"][3] > 1.5 * pitch["counts"][0]


def test_generalise_counts_the_other_pairs(serial):
    for row in serial.rows["generalise"]:
        assert list(row["others"]) == ["2.png"]
        assert row["others"]["2.png"]["starred"]
        assert row["others"]["2.png"]["score_initial"] < row["others"]["2.png"]["score_final"]
    assert {row["calibration"] for row in serial.rows["generalise"]} == {"2020-02-01", "2020-03-01"}


def test_sequences_carry_over(serial):
    orders = {row["order"]: row["steps"] for row in serial.rows["sequential"]}
    assert {name: len(steps) for name, steps in orders.items()} == {
        "random": 2, "better half twice": 2, "random twice": 4
    }  # fmt: skip
    first, second = orders["random"]
    assert first["image"] != second["image"]
    assert [step["image"] for step in orders["random twice"]] == 2 * [first["image"], second["image"]]
    assert len({step["image"] for step in orders["better half twice"]}) == 1
    for steps in orders.values():
        for before, after in pairwise(steps):
            assert after["extrinsics"]["start"] == before["extrinsics"]["found"]
        assert all(step["cost_budgeted"] <= TINY.iterations * 10 for step in steps)


@pytest.mark.slow
def test_any_executor_gives_the_same_rows(log, serial):
    with ThreadPoolExecutor(2) as pool:
        assert timeless(reproduce(log, executor=pool, **COUNT)) == timeless(serial)


@pytest.mark.slow
def test_an_interrupted_run_continues(log, serial, tmp_path):
    done = []

    def stop_after_two(*numbers):
        done.append(numbers)
        if len(done) == 2:
            raise KeyboardInterrupt

    options = {**COUNT, "output": tmp_path / "out"}
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / ".settings.json.0123abcd.tmp").touch()  # of a run that was killed while it wrote
    cut = reproduce(log, ["ex-nihilo", "repair"], **options, progress=stop_after_two)
    assert cut.unfinished == 2
    assert sum(map(len, cut.rows.values())) == 2
    rows = tmp_path / "out" / "rows.jsonl"
    with open(rows, "a") as file:
        file.write('{"key": "repair:half a li')  # the machine stopped while it wrote

    options["progress"] = lambda *numbers: done.append(numbers)
    whole = reproduce(log, ["ex-nihilo", "repair"], **options)
    assert whole.unfinished == 0
    assert done == [(1, 4), (2, 4), (3, 4), (4, 4)]  # nothing was done twice
    mine = timeless(whole)
    assert mine == {name: timeless(serial)[name] for name in mine}
    assert len(rows.read_text().splitlines()) == 4
    assert timeless(reproduce(log, ["repair"], **options)) == {"repair": mine["repair"]}
    assert len(done) == 4


def test_a_folder_of_other_settings_is_left_alone(log, tmp_path):
    reproduce(log, ["validity"], **COUNT, output=tmp_path / "out")
    before = (tmp_path / "out" / "rows.jsonl").read_bytes()
    with pytest.raises(InputError, match="results of other settings"):
        reproduce(log, ["validity"], **COUNT, seed=1, output=tmp_path / "out")
    assert (tmp_path / "out" / "rows.jsonl").read_bytes() == before


def test_a_folder_of_other_things_is_left_alone(log, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "validity.csv").write_text("mine")
    with pytest.raises(InputError, match="holds files that `reproduce` did not write"):
        reproduce(log, ["validity"], **COUNT, output=tmp_path / "out")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["validity.csv"]


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("damage", [b"\x00\x00\n", b'{"key": 5, "row": {}}\n', b"[]\n", b"\xff\xfe\n"])
def test_damaged_rows_are_done_again(log, serial, tmp_path, damage):
    reproduce(log, ["ex-nihilo"], **COUNT, output=tmp_path / "out")
    path = tmp_path / "out" / "rows.jsonl"
    first, second = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(damage + second)
    assert timeless(reproduce(log, ["ex-nihilo"], **COUNT, output=tmp_path / "out")) == {
        "ex_nihilo": timeless(serial)["ex_nihilo"]
    }
    assert len(path.read_bytes().splitlines()) == 2
    assert first.split(b'"row"')[0] in path.read_bytes()


def test_another_lens_or_truth_is_another_run(log, tmp_path):
    reproduce(log, ["validity"], **COUNT, output=tmp_path / "out")
    unknown = replace(log, missions=tuple(replace(mission, truth=None) for mission in log.missions))
    rig = log.calibrations["2020-01-01"]
    lens = replace(rig.left, matrix=rig.left.matrix * np.array([[1.01], [1.01], [1.0]]))
    other = replace(log, calibrations={**log.calibrations, "2020-01-01": replace(rig, left=lens)})
    for changed in (unknown, other):
        with pytest.raises(InputError, match="other settings"):
            reproduce(changed, ["validity"], **COUNT, output=tmp_path / "out")


@pytest.mark.parametrize(("starred", "left"), [(set(), "012"), ({"1"}, "02"), ({"0", "1", "2"}, "012")])
def test_pairs_without_a_star_are_those_of_a_mission_unless_all_have_one(starred: set[str], left: str):
    image = np.arange(48 * 64, dtype=np.float32).reshape(48, 64) % 256
    found = unstarred(Mission("a", "b", tuple(Pair(image, image, name) for name in "012"), frozenset(starred)))
    assert [pair.name for pair in found] == list(left)


def test_a_pair_is_read_for_each_task(scene):
    """A log may be larger than the memory."""
    taken, alive, most = scene(size=(64, 48)), weakref.WeakSet(), []

    def read():
        pair = replace(taken.pairs[0])
        alive.add(pair)
        most.append(len(alive))
        return pair

    pairs = LazyPairs([read] * 20, [f"{number}.png" for number in range(20)])
    log = Log("long", {"2020-01-01": taken.rig}, (Mission("2020-01-02", "2020-01-01", pairs),))
    extent = Extent(sweeps=1, points=3, matchers=())
    found = reproduce(log, ["validity"], schedules=("count",), extent=extent, matcher=sr.BM(num_disparities=16))
    assert found.errors == {}
    assert len(found.rows["validity"]) == 20
    assert max(most) <= 4 + 2  # the survey of the disparity range looks at four together


def test_a_damaged_image_is_said(tmp_path, scene):
    sr.io.save_scene(scene(frames=2), tmp_path / "scene")
    path = max((tmp_path / "scene" / "left").iterdir())
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(InputError, match="the image is truncated"):
        reproduce(load_log(tmp_path / "scene"), ["ex-nihilo"], schedules=("count",))


LOCK = "import fcntl, sys; file = open(sys.argv[1], 'a'); fcntl.flock(file, 2); print('there', flush=True); input()"


def test_two_runs_in_one_folder(log, tmp_path):
    """A killed one leaves no lock."""
    first = reproduce(log, ["validity"], **COUNT, output=tmp_path / "out")
    (lock,) = (path for path in (tmp_path / "out").iterdir() if path.name.startswith("."))
    run = [sys.executable, "-c", LOCK, str(lock)]
    with subprocess.Popen(run, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "there\n"
        with pytest.raises(InputError, match="another run is working there"):
            reproduce(log, ["validity"], **COUNT, output=tmp_path / "out")
        other.kill()
    assert reproduce(log, ["validity"], **COUNT, output=tmp_path / "out").rows == first.rows


def test_a_full_disk_stops_it_in_a_sentence(log, tmp_path):
    with full_disk(nth=2), pytest.raises(InputError, match=r"rows.jsonl: cannot be written \(No space left on device"):
        reproduce(log, ["validity"], **COUNT, output=tmp_path)


def test_the_loss_of_workers_leaves_tasks(log, tmp_path):
    class Dying(ThreadPoolExecutor):
        def submit(self, function, *arguments):
            if arguments[0].task.logged_pair.image == "2.png":
                lost = Future()
                lost.set_exception(RuntimeError("the worker was killed"))
                return lost
            return super().submit(function, *arguments)

    with Dying(1) as pool:
        found = reproduce(log, ["validity"], **COUNT, executor=pool, output=tmp_path / "out")
    whole = len(found.rows["validity"]) + len(found.rows["sweeps"])
    assert (found.unfinished, found.lost, found.errors) == (2, ("the worker was killed",), {})
    again = reproduce(log, ["validity"], **COUNT, output=tmp_path / "out")
    assert again.unfinished == 0
    assert len(again.rows["validity"]) + len(again.rows["sweeps"]) == whole + 2


def test_a_strategy_takes_the_stages_that_it_can_do():
    def kinds(name):
        found = methods(("count", "default"), name)
        return {method.name: [type(stage.strategy).__name__ for stage in method.schedule.stages] for method in found}

    usual, secant, solver = kinds(None), kinds("secant"), kinds("optimistix-gauss-newton")
    assert (secant["count"], secant["default"]) == (["Secant"], ["Secant", *usual["default"][1:]])
    assert (solver["count"], solver["default"]) == (["Compass"], ["Compass", "GaussNewton", "GaussNewton"])


def test_kinds_of_matchers_of_one_name_are_refused(log):
    twice = replace(TINY, matchers=(sr.SAD(block_size=7), sr.SAD(block_size=11)))
    with pytest.raises(InputError, match="give each kind of matcher once"):
        reproduce(log, ["validity"], schedules=("count",), extent=twice)


def test_a_log_of_rectified_images_gets_wrong_calibrations_too(log):
    """All dates have the same extrinsics there; only the length of the baseline, which nothing sees, differs."""
    rig = log.calibrations["2020-01-01"]
    longer = rig.with_extrinsics(rig.extrinsics * np.array([1, 1, 1, 1.02, 1.02, 1.02]))
    same = Log("rectified", {"2020-01-01": rig, "2020-02-01": longer}, log.missions[:1])
    (row,) = reproduce(same, ["repair"], **COUNT).rows["repair"]
    assert row["calibration"].startswith("drawn-")


@pytest.mark.slow
def test_a_rendered_log_does_not_mix_with_another(tmp_path, small_synthetic_log):
    log = synthetic_log(0, quick=True, folder=tmp_path / "log")
    assert [len(mission.pairs) for mission in log.missions] == [1, 1]
    before = sorted(path.stat().st_mtime_ns for path in (tmp_path / "log").rglob("*.png"))
    assert synthetic_log(0, quick=True, folder=tmp_path / "log").missions[0].pairs[0].size == (160, 120)
    assert sorted(path.stat().st_mtime_ns for path in (tmp_path / "log").rglob("*.png")) == before
    for other in ({"seed": 1, "quick": True}, {"seed": 0}):
        with pytest.raises(InputError, match="other than this log"):
            synthetic_log(**other, folder=tmp_path / "log")


def test_a_task_that_fails_is_said_and_tried_again(log, tmp_path, moody):
    def at_first(run):
        if run == 1:
            raise RuntimeError("the disk is on fire")

    moody(at_first)
    options = {**COUNT, "strategy": "moody", "output": tmp_path / "out"}
    found = reproduce(log, ["ex-nihilo"], **options)
    assert len(found.rows["ex_nihilo"]) == len(found.errors) == 1
    (said,) = found.errors.values()
    assert "the disk is on fire" in said
    moody()
    again = reproduce(log, ["ex-nihilo"], **options)
    assert again.errors == {}
    assert len(again.rows["ex_nihilo"]) == 2


@pytest.mark.slow
def test_a_log_with_one_calibration_gets_wrong_ones(log):
    mission = log.missions[0]
    single = Log("one", {"2020-01-01": log.calibration_of(mission)}, (mission,))
    found = reproduce(single, ["validity", "repair"], **COUNT)
    assert list(found.rows["validity"][0]["counts"]) == ["2020-01-01", *(f"drawn-{i}" for i in range(4))]
    (row,) = found.rows["repair"]
    assert row["calibration"].startswith("drawn-")
    assert 0.1 < max(row["start_error"]["rotation_error_deg"].values()) <= 2.5


def test_unknown_names(log):
    with pytest.raises(InputError, match="unknown experiment 'valid'"):
        reproduce(log, ["valid"])
    with pytest.raises(InputError, match="nothing to run"):
        reproduce(log, [])
    with pytest.raises(InputError, match="nothing to run"):
        reproduce(log, schedules=("fast",))
    with pytest.raises(InputError, match="compas"):
        reproduce(log, strategy="compas")


@pytest.mark.slow
def test_files(log, serial, tmp_path):
    written = write_files(serial, log, tmp_path / "out")
    assert {path.name for path in written} == {path.name for path in (tmp_path / "out").iterdir()}
    stems = {"validity", "sweeps", "repair", "generalise", "ex_nihilo", "sequential"}
    figures = stems | {"ex_nihilo_disparity"}
    assert {f"{name}.{suffix}" for name in figures for suffix in ("png", "pdf")} <= {path.name for path in written}
    content = json.loads((tmp_path / "out" / "ex_nihilo.json").read_text())
    assert content["schema"] == "stereorecal.reproduce/1"
    assert content["summary"][0]["schedule"] == "the paper"
    lines = (tmp_path / "out" / "ex_nihilo.csv").read_text().splitlines()
    assert len(lines) == 1 + len(serial.rows["ex_nihilo"])
    cells = dict(zip(lines[0].split(","), lines[1].split(","), strict=True))
    row = serial.rows["ex_nihilo"][0]
    assert int(cells["score_final"]) == row["score_final"]
    assert float(cells["rotation_error_deg.pitch"]) == row["rotation_error_deg"]["pitch"]
    steps = (tmp_path / "out" / "sequential.csv").read_text().splitlines()
    assert len(steps) == 1 + 2 + 2 + 4


def test_every_experiment_can_be_asked_for():
    assert list(EXPERIMENTS) == ["validity", "repair", "generalise", "ex-nihilo", "sequential"]


def test_figures_say_what_they_show(serial):
    for name, figure in experiment_figures(serial.rows).items():
        shown = [axis for axis in figure.axes if axis.get_visible()]
        assert shown, name
        for axis in shown:
            assert axis.has_data(), name
        labels = [*(axis.get_xlabel() for axis in shown), figure.get_supxlabel()]
        assert any(labels) or name == "repair", name  # whose ticks are the names of pairs
        heights = [axis.get_ylabel() for axis in shown]
        assert any("[" in label or "r " in label or "count" in label for label in heights), name
        legends = [*figure.legends, *filter(None, (axis.get_legend() for axis in shown))]
        assert any(legend.get_texts() for legend in legends), name
