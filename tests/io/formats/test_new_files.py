"""The product of what a new file may be: every format, every lens that it has a place for, every way in which cameras
stand, either camera first. It is read as what it is, written back byte for byte, and changed in its numbers alone."""

import itertools
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from every import (
    HOLDS,
    NEW,
    STANDS,
    assert_same,
    beside,
    contents,
    new_files,
    of_model,
    unit_of,
    write_exchanged,
)
from refusals import refused

from stereorecal.io import load_rig, save_rig

CHANGE = np.array([0.01, 0.02, -0.03, -0.01, 0.001, 0.002])
NUMBER = re.compile(r"-?\d+\.?\d*(e[-+]?\d+)?")
CASES = [(model, name, (0, 0), False) for model in HOLDS for name in HOLDS[model]]
CASES += [("radtan", name, (0, 0), True) for name in NEW]
CASES += [("radtan", name, turns, False) for name, turns in zip(NEW, itertools.cycle(STANDS.values()), strict=False)]
QUICK = len(CASES)  # each way to stand in two formats; the others are slow
CASES += [("radtan", name, turns, False) for name in NEW for turns in STANDS.values()]


@pytest.mark.slow(after=QUICK)
@pytest.mark.parametrize(("model", "name", "turns", "exchanged"), CASES)
def test_new_files(tmp_path: Path, model: str, name: str, turns: tuple[int, int], exchanged: bool):
    rig, paths, unit = replace(of_model(model), turns=turns), new_files(tmp_path, name), unit_of(name)
    cameras, new = ("right", "left") if exchanged else None, beside(paths)
    if exchanged:
        write_exchanged(rig, name, paths)
        refused(lambda: load_rig(paths, unit=unit), "left and right are exchanged: T[0] must be negative")
        refused(lambda: load_rig(paths, unit=unit), "--cameras right,left" if len(paths) == 1 else "file first")
    else:
        save_rig(rig, paths, format=name)
    read = load_rig(paths, unit=unit, cameras=cameras)
    assert (read.source.format, read.left.size, read.turns) == (name, rig.sizes_taken[0], (0, 0))
    stood = read.side_by_side()
    assert stood.turns == turns
    assert_same(stood, rig)
    assert_same(stood.as_taken(), read)
    for same in (read, stood):
        save_rig(same, new, overwrite=True)
        assert contents(new) == contents(paths)
    moved = replace(stood, extrinsics=stood.extrinsics + CHANGE)
    save_rig(moved, new, overwrite=True)
    found = load_rig(new, unit=unit, cameras=cameras)
    assert_same(found.side_by_side(), moved)
    for camera, other in ((found.left, read.left), (found.right, read.right)):
        np.testing.assert_array_equal(camera.matrix, other.matrix)
        np.testing.assert_array_equal(camera.distortion, other.distortion)
    for old, now in zip(paths, new, strict=True):
        assert NUMBER.sub("#", old.read_text()).split() == NUMBER.sub("#", now.read_text()).split()
    assert contents(new) != contents(paths)
    left = replace(stood.left, matrix=np.array(stood.left.matrix) + np.diag([0.125, 0.25, 0.0]))
    changed = replace(moved, left=left)
    save_rig(changed, new, overwrite=True)
    assert_same(load_rig(new, unit=unit, cameras=cameras).side_by_side(), changed)
    np.testing.assert_array_equal(load_rig(new, unit=unit, cameras=cameras).right.matrix, read.right.matrix)
    save_rig(replace(stood, source=None), tmp_path / "other.json")
    assert_same(load_rig(tmp_path / "other.json").side_by_side(), rig)
