"""Read, write, read is the identity for every format, and what was not estimated stays as it was."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import samples
from every import SAMPLES, Sample, unchanged
from hypothesis import given, settings, strategies as st

from stereorecal.geometry import StereoRig
from stereorecal.io import load_rig, save_rig

each = pytest.mark.parametrize("sample", SAMPLES.values(), ids=SAMPLES.keys())
NEW = ["opencv", "ros", "kalibr", "euroc", "boofcv", "kitti-raw", "basalt", "depthai", "stereorecal"]
ENDINGS = {"basalt": ".json", "depthai": ".json", "stereorecal": ".json", "kitti-raw": ".txt"}

angles = st.tuples(*[st.floats(-0.5, 0.5)] * 3)
shifts = st.tuples(st.floats(-2.0, -0.02), st.floats(-0.015, 0.015), st.floats(-0.015, 0.015))


def loaded(paths: list[Path], sample: Sample) -> StereoRig:
    return load_rig(*paths, unit=sample.unit, size=sample.size)


def place_of(paths: list[Path]):
    return paths[0] if len(paths) == 1 else tuple(paths)


def assert_same(one: StereoRig, other: StereoRig) -> None:
    np.testing.assert_allclose(one.extrinsics, other.extrinsics, rtol=0, atol=1e-12)
    for a, b in ((one.left, other.left), (one.right, other.right)):
        assert a.size == b.size
        np.testing.assert_allclose(a.matrix, b.matrix, rtol=1e-12)
        length = max(a.distortion.size, b.distortion.size)
        lenses = [np.concatenate([c.distortion, np.zeros(length - c.distortion.size)]) for c in (a, b)]
        np.testing.assert_allclose(*lenses, rtol=0, atol=1e-12)


@each
@settings(max_examples=max(4, settings.default.max_examples // 12), deadline=None)
@given(angles=angles, shift=shifts)
def test_into_a_copy_of_the_file(tmp_path_factory: pytest.TempPathFactory, sample: Sample, angles, shift):
    folder = tmp_path_factory.mktemp("formats")
    paths = sample.write(folder)
    before = loaded(paths, sample)
    rectified = [0.0, 0.0, 0.0, shift[0], 0.0, 0.0]
    rig = before.with_extrinsics(np.array(rectified if sample.rectified else [*angles, *shift]))
    new = [folder / f"new-{path.name}" for path in paths]
    save_rig(rig, place_of(new))
    assert_same(loaded(new, sample), rig)
    for old, path in zip(sample.texts, new, strict=True):
        assert unchanged(path.read_text(), sample) == unchanged(old, sample)
    again = [folder / f"again-{path.name}" for path in paths]
    save_rig(loaded(new, sample), place_of(again))
    assert [path.read_bytes() for path in again] == [path.read_bytes() for path in new]


@each
def test_a_rig_that_did_not_change_leaves_every_byte(tmp_path: Path, sample: Sample):
    paths = sample.write(tmp_path)
    for path in paths:
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    new = [tmp_path / f"new-{path.name}" for path in paths]
    save_rig(loaded(paths, sample), place_of(new))
    assert [path.read_bytes() for path in new] == [path.read_bytes() for path in paths]


@pytest.mark.parametrize("name", [n for n in SAMPLES if n != "opencv xml"])
def test_comments_and_order_stay(tmp_path: Path, name: str):
    """Line by line: only lines with the numbers of the extrinsics differ."""
    sample = SAMPLES[name]
    paths = sample.write(tmp_path)
    before = loaded(paths, sample)
    change = np.array([0, 0, 0, -0.01, 0, 0] if sample.rectified else [0.01, 0.02, 0.03, -0.01, 0.001, 0.001])
    new = [tmp_path / f"new-{path.name}" for path in paths]
    save_rig(before.with_extrinsics(before.extrinsics + change), place_of(new))
    for old, path in zip(sample.texts, new, strict=True):
        lines, written = old.splitlines(), path.read_text().splitlines()
        assert len(lines) == len(written)
        for line, other in zip(lines, written, strict=True):
            comment = line.partition("#")[2]
            assert other.partition("#")[2] == comment
            assert line == other or any(digit in line for digit in "0123456789") or "dt" in line
        kept = sum(line == other for line, other in zip(lines, written, strict=True))
        assert kept >= len(lines) * 0.5


@pytest.mark.parametrize("name", NEW)
@settings(max_examples=max(4, settings.default.max_examples // 12), deadline=None)
@given(angles=angles, shift=shifts, lens=st.lists(st.floats(-0.2, 0.2), min_size=4, max_size=4))
def test_new_files(tmp_path_factory: pytest.TempPathFactory, name: str, angles, shift, lens):
    folder, rig = tmp_path_factory.mktemp("formats"), samples.rig_of([*angles, *shift], np.array(lens))
    count = 2 if name in ("ros", "euroc") else 1
    paths = [folder / f"new{index}{ENDINGS.get(name, '.yaml')}" for index in range(count)]
    save_rig(rig, place_of(paths), format=name)
    again = load_rig(*paths, unit="m" if name in ("opencv", "boofcv") else None)
    assert again.source.format == name
    assert_same(again, rig)


@pytest.mark.parametrize("name", [n for n in SAMPLES if not SAMPLES[n].rectified])
def test_other_intrinsics(tmp_path: Path, name: str):
    """They are written where they differ, for that camera only; a lens model of fewer coefficients grows."""
    sample = SAMPLES[name]
    paths = sample.write(tmp_path)
    before = loaded(paths, sample)
    matrix = np.array(before.right.matrix) + np.diag([0.125, 0.25, 0.0])
    lens = np.concatenate([before.right.distortion[:4] * 1.5, np.zeros(before.right.distortion.size - 4)])
    rig = replace(before, right=replace(before.right, matrix=matrix, distortion=lens))
    new = [tmp_path / f"new-{path.name}" for path in paths]
    save_rig(rig, place_of(new))
    after = loaded(new, sample)
    assert_same(after, rig)
    np.testing.assert_array_equal(after.left.matrix, before.left.matrix)
    assert not np.array_equal(after.right.matrix, before.right.matrix)


def test_a_lens_that_grows(tmp_path: Path):
    """A fifth coefficient, into a file with lists of four and into BoofCV's list of two radial terms."""
    four = samples.OPENCV.replace("cols: 5", "cols: 4").replace("-0.0018, 0. ]", "-0.0018 ]")
    for name, text in (("opencv yaml", four.replace("-0.002, 0. ]", "-0.002 ]")), ("boofcv", samples.BOOFCV)):
        sample = replace(SAMPLES[name], texts=(text,))
        (path,) = sample.write(tmp_path)
        before = loaded([path], sample)
        assert before.left.distortion.size == 4
        cameras = [replace(c, distortion=np.array([*c.distortion, 0.0625])) for c in (before.left, before.right)]
        rig = replace(before, left=cameras[0], right=cameras[1])
        save_rig(rig, tmp_path / f"new{sample.ending}")
        assert_same(load_rig(tmp_path / f"new{sample.ending}", unit="mm"), rig)


@each
def test_another_template(tmp_path: Path, sample: Sample):
    """A rig from nowhere, written into a file that somebody has."""
    paths = sample.write(tmp_path)
    before = loaded(paths, sample)
    shift = np.array([0, 0, 0, -0.01, 0, 0])
    rig = StereoRig(before.left, before.right, before.extrinsics + shift)
    new = [tmp_path / f"new-{path.name}" for path in paths]
    save_rig(rig, place_of(new), template=place_of(paths), unit=sample.unit)
    assert_same(loaded(new, sample), rig)
    assert unchanged(new[0].read_text(), sample) == unchanged(sample.texts[0], sample)


@pytest.mark.parametrize(
    ("terms", "most"), [((0.1, 0, 0, 0, 0, 0, 0, 0), 5), ((0.1,) * 8 + (0,) * 6, 8), ((0.1,) * 4, 5)]
)
@pytest.mark.parametrize("format", ["opencv", "stereorecal", "depthai"])
def test_zero_terms_of_a_lens_are_left_out(tmp_path: Path, format: str, terms, most: int):
    """So that the digits of a repair do not depend on the format."""
    lens = np.array(terms, float)
    rig = replace(samples.RIG, left=replace(samples.RIG.left, distortion=lens))
    path = tmp_path / f"rig{ENDINGS.get(format, '.yaml')}"
    save_rig(rig, path, format=format)
    found = load_rig(path, unit=None if format != "opencv" else "m").left.distortion
    assert found.size <= most
    np.testing.assert_array_equal(found, np.resize(lens, 14)[: found.size] * (np.arange(found.size) < lens.size))
    assert not np.any(lens[found.size :])
