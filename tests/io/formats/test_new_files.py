"""The product of what a new file may be: every format, every lens that it has a place for, every way in which cameras
stand, either camera first. It is read as what it is, written back byte for byte, and changed in its numbers alone."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from every import (
    HOLDS,
    NEW,
    STANDS,
    angles,
    assert_same,
    beside,
    contents,
    new_files,
    of_model,
    shifts,
    unit_of,
    write_exchanged,
)
from hypothesis import given, settings, strategies as st
from refusals import refused

from stereorecal.io import load_rig, save_rig

CHANGE = np.array([0.01, 0.02, -0.03, -0.01, 0.001, 0.002])
NUMBER = re.compile(r"-?\d+\.?\d*(e[-+]?\d+)?")
HELD = [(model, name) for model in HOLDS for name in HOLDS[model]]
CASES = [(model, name, (0, 0), False) for model, name in HELD]
CASES += [("radtan", name, turns, False) for name in NEW for turns in STANDS.values()]
CASES += [("radtan", name, (0, 0), True) for name in NEW]


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


@pytest.mark.parametrize(("model", "name"), HELD)
@settings(max_examples=max(5, settings.default.max_examples // 12), deadline=None)
@given(angles=angles, shift=shifts, scale=st.floats(0.5, 1.0), turns=st.sampled_from([(0, 0), *STANDS.values()]))
def test_any_rig(tmp_path_factory, model: str, name: str, angles, shift, scale: float, turns: tuple[int, int]):
    turns = turns if model == "radtan" and name == "opencv" else (0, 0)
    rig, unit = replace(of_model(model, [*angles, *shift], scale), turns=turns), unit_of(name)
    paths = new_files(tmp_path_factory.mktemp("new"), name)
    save_rig(rig, paths, format=name)
    again = load_rig(paths, unit=unit).side_by_side()
    assert again.turns == turns
    assert_same(again, rig)
    right = replace(again.right, distortion=np.asarray(again.right.distortion) * 0.9)
    moved = replace(again, right=right, extrinsics=again.extrinsics + np.array([0.01, 0.01, 0.01, -0.01, 0, 0]))
    save_rig(moved, beside(paths))
    found = load_rig(beside(paths), unit=unit).side_by_side()
    assert_same(found, moved)
    np.testing.assert_array_equal(found.left.distortion, again.left.distortion)
