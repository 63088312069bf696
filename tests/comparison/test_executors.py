"""Any executor gives the same rows; pairs from files travel as paths."""

import pickle
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import pytest

from stereorecal.comparison import compare_scenes
from stereorecal.io import load_scene, save_scene
from stereorecal.matching import SAD
from stereorecal.strategies import Budget

SMALL = {
    "schedule": "count",
    "matcher": SAD(num_disparities=24),
    "draws": 3,
    "scale": 0.5,
    "budget": Budget(evaluations=10),
}


def rows(table):
    return [replace(trial, seconds=None) for trial in table.trials]


@pytest.fixture(scope="module")
def serial(scene):
    return rows(compare_scenes([scene()], **SMALL))


@pytest.mark.slow
def test_a_worker_that_misses_an_image_says_so(scene, tmp_path):
    save_scene(scene(), tmp_path / "saved")
    from_file = load_scene(tmp_path / "saved")
    (tmp_path / "saved" / "left.png").unlink()
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        found = rows(compare_scenes([replace(from_file, reference="truth")], executor=pool, **SMALL))
    assert [row.status for row in found] == ["FAILED"] * 3
    assert all("left.png" in row.message for row in found)


class Weighing(ThreadPoolExecutor):
    """Knows how many bytes its largest task takes on its way to another process, and that it arrives whole."""

    largest = 0

    def submit(self, *task, **options):
        travelling = pickle.dumps(task)
        self.largest = max(self.largest, len(travelling))
        return super().submit(*pickle.loads(travelling), **options)


def test_pairs_from_files_travel_as_paths(scene, serial, tmp_path):
    in_memory = scene()
    save_scene(in_memory, tmp_path / "saved")
    from_file = replace(load_scene(tmp_path / "saved"), reference="truth")
    found, largest = [], []
    for given in (from_file, in_memory):
        with Weighing(1) as pool:
            found.append(rows(compare_scenes([given], executor=pool, **SMALL)))
            largest.append(pool.largest)
    assert largest[0] < 8_000
    assert largest[1] > 2 * 160 * 120
    assert [row.status for row in found[0]] == [row.status for row in serial]
    assert found[1] == serial
