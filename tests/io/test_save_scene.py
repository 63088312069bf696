"""Saving a scene: what is written comes back, nothing is overwritten, mixed or left behind."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from machine import at_call, raising
from refusals import refused
from trees import SIZE, refused_scene, texture

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io import load_scene, save_scene
from stereorecal.recordings import Pair, Scene


def scene_of(frames: int = 1, rig: StereoRig | None = None, names: list[str] | None = None, **changes: Any) -> Scene:
    names = names or [f"pair {i}" for i in range(frames)]
    pairs = tuple(Pair(*(texture(2 * i + s).astype(np.float32) for s in (0, 1)), name) for i, name in enumerate(names))
    return Scene("demo", rig, pairs, info={"max_disparity_px": 12, "notes": "größer"}, **changes)


def rig_of(extrinsics: Any) -> StereoRig:
    matrix = np.array([[20.1, 0, 11.3], [0, 19.9, 7.7], [0, 0, 1]])
    return StereoRig(
        Camera(SIZE, matrix, np.array([0.1, -0.02, 1 / 3, 1e-7])),
        Camera(SIZE, matrix * 1.0),
        np.array(extrinsics),
    )


def files_in(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def assert_same(a: Scene, b: Scene) -> None:
    assert a.reference == b.reference
    assert dict(a.info) == dict(b.info)
    assert len(a.pairs) == len(b.pairs)
    for p, q in zip(a.pairs, b.pairs, strict=True):
        np.testing.assert_array_equal(p.left, q.left)
        np.testing.assert_array_equal(p.right, q.right)
    assert (a.rig is None) == (b.rig is None)
    if a.rig is not None and b.rig is not None:
        np.testing.assert_allclose(a.rig.extrinsics, b.rig.extrinsics, rtol=0, atol=1e-12)
        for side in ("left", "right"):
            one, two = getattr(a.rig, side), getattr(b.rig, side)
            assert one.size == two.size
            np.testing.assert_array_equal(one.matrix, two.matrix)
            np.testing.assert_array_equal(one.distortion, two.distortion)


@settings(max_examples=10)
@given(
    angles=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    shift=st.tuples(st.floats(-2.0, -0.01), st.floats(-0.009, 0.009), st.floats(-0.009, 0.009)),
    reference=st.sampled_from(["stored", "truth"]),
)
def test_round_trip(tmp_path_factory: pytest.TempPathFactory, angles, shift, reference: str):
    scene = scene_of(2, rig_of([*angles, *shift]), reference=reference)
    folder = tmp_path_factory.mktemp("scenes") / "new" / "folder"
    save_scene(scene, folder)
    again = load_scene(folder)
    assert_same(scene, again)
    save_scene(again, folder, overwrite=True)
    assert_same(load_scene(folder), again)


@pytest.mark.parametrize("frames", [1, 3])
def test_round_trip_without_calibration(tmp_path: Path, frames: int):
    scene = scene_of(frames)
    save_scene(scene, tmp_path)
    assert_same(load_scene(tmp_path), scene)


def test_what_is_written(tmp_path: Path):
    save_scene(scene_of(1, rig_of([0, 0, 0, -0.12, 0.0, 0.05])), tmp_path / "one")
    assert files_in(tmp_path / "one") == ["calib.json", "left.png", "right.png"]
    content = json.loads((tmp_path / "one" / "calib.json").read_text())
    assert content["baseline_m"] == pytest.approx(0.13)
    assert content["max_disparity_px"] == 12
    assert "extrinsics" not in content
    assert cv2.imread(str(tmp_path / "one" / "left.png"), cv2.IMREAD_UNCHANGED).dtype == np.uint8


@pytest.mark.parametrize(
    ("names", "files"),
    [
        (["2.png", "10.png"], ["2", "10"]),
        (["10.png", "2.png"], ["000000", "000001"]),
        (["a", "a"], ["000000", "000001"]),
        (["", "x"], ["000000", "000001"]),
        (["../../up", "x"], ["up", "x"]),
        ([".hidden", "x"], ["000000", "000001"]),
        (["a\nb", "x"], ["000000", "000001"]),
    ],
)
def test_file_names_keep_the_order(tmp_path: Path, names: list[str], files: list[str]):
    scene = scene_of(rig=rig_of([0, 0, 0, -0.1, 0, 0]), names=names)
    save_scene(scene, tmp_path / "s")
    assert files_in(tmp_path / "s") == sorted(
        ["calib.json", *(f"{s}/{n}.png" for s in ("left", "right") for n in files)]
    )
    assert_same(load_scene(tmp_path / "s"), scene)


def test_values_are_rounded_and_clipped(tmp_path: Path):
    left = np.array([[0.4, 0.6], [255.0, 254.7]], np.float32)
    save_scene(Scene("s", None, (Pair(left, left[::-1].copy()),)), tmp_path)
    np.testing.assert_array_equal(load_scene(tmp_path).pairs[0].left, [[0, 1], [255, 255]])


def test_nothing_is_overwritten_unless_allowed(tmp_path: Path):
    (tmp_path / "right.png").write_bytes(b"precious")
    refused(lambda: save_scene(scene_of(), tmp_path), "right.png: the file exists already")
    assert files_in(tmp_path) == ["right.png"]
    assert (tmp_path / "right.png").read_bytes() == b"precious"
    save_scene(scene_of(), tmp_path, overwrite=True)
    assert_same(load_scene(tmp_path), scene_of())


@pytest.mark.parametrize("first", [1, 3])
def test_scenes_are_never_mixed(tmp_path: Path, first: int):
    save_scene(scene_of(first), tmp_path)
    before = {name: (tmp_path / name).read_bytes() for name in files_in(tmp_path)}
    refused(lambda: save_scene(scene_of(2), tmp_path, overwrite=True), "would mix with the scene")
    assert {name: (tmp_path / name).read_bytes() for name in files_in(tmp_path)} == before


def test_scenes_that_cannot_be_written_leave_nothing(tmp_path: Path):
    rig = rig_of([0, 0, 0, -0.1, 0, 0])
    bad = {
        "no image pair": Scene("s", rig, ()),
        "calibration is for 48x32": scene_of(1, rig.resized((48, 32))),
        "finite": dataclasses.replace(scene_of(), info={"number": float("nan")}),
    }
    for words, scene in bad.items():
        refused(lambda scene=scene: save_scene(scene, tmp_path / "s"), words)
    assert not (tmp_path / "s").exists()
    (tmp_path / "file").write_text("x")
    refused(lambda: save_scene(scene_of(), tmp_path / "file"), "cannot become a folder")


def test_an_interrupted_save_leaves_whole_files_and_no_scene(tmp_path: Path):
    with at_call("replace", raising(KeyboardInterrupt), 3), pytest.raises(KeyboardInterrupt):
        save_scene(scene_of(2), tmp_path)
    assert len(files_in(tmp_path)) == 2
    assert all(cv2.imread(str(tmp_path / name)) is not None for name in files_in(tmp_path))
    refused_scene(tmp_path, "no such file")


def set_key(folder: Path, key: str, value: Any) -> None:
    path = folder / "calib.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), key: value}))


def test_times_are_kept(tmp_path: Path):
    """With the scene, where all pairs know theirs; what is no list of as many numbers is passed over."""
    scene = scene_of(2)
    assert [pair.time for pair in scene.pairs] == [None, None]
    pairs = tuple(dataclasses.replace(pair, time=0.1 * n) for n, pair in enumerate(scene.pairs))
    save_scene(dataclasses.replace(scene, pairs=pairs), tmp_path)
    assert [pair.time for pair in load_scene(tmp_path).pairs] == [0.0, 0.1]
    for wrong in ([0.0], ["a", "b"], 3, [0.0, None]):
        set_key(tmp_path, "times_s", wrong)
        assert [pair.time for pair in load_scene(tmp_path).pairs] == [None, None]


def test_the_readout_of_rolling_shutters_is_kept(tmp_path: Path):
    scene = scene_of(2)
    save_scene(dataclasses.replace(scene, pairs=tuple(pair.read_out(0.02) for pair in scene.pairs)), tmp_path)
    assert [pair.readout for pair in load_scene(tmp_path).pairs] == [0.02, 0.02]
    assert json.loads((tmp_path / "calib.json").read_text())["readout_s"] == 0.02
    set_key(tmp_path, "readout_s", -1)
    refused_scene(tmp_path, "a rolling shutter", about="")
