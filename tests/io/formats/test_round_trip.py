"""Read, write, read is the identity for every format, and what was not estimated stays as it was."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import samples
from every import SAMPLES, Sample, angles, assert_same, beside, contents, new_files, shifts, unchanged, unit_of
from hypothesis import given, settings

from stereorecal.geometry import StereoRig
from stereorecal.io import load_rig, save_rig

each = pytest.mark.parametrize("sample", SAMPLES.values(), ids=SAMPLES.keys())


@each
@settings(max_examples=max(4, settings.default.max_examples // 12), deadline=None)
@given(angles=angles, shift=shifts)
def test_into_a_copy_of_the_file(tmp_path_factory: pytest.TempPathFactory, sample: Sample, angles, shift):
    paths = sample.write(tmp_path_factory.mktemp("formats"))
    new, again = beside(paths), beside(paths, "again")
    extrinsics = [0.0, 0.0, 0.0, shift[0], 0.0, 0.0] if sample.rectified else [*angles, *shift]
    rig = sample.load(paths).with_extrinsics(np.array(extrinsics))
    save_rig(rig, new)
    assert_same(sample.load(new), rig)
    for old, path in zip(sample.texts, new, strict=True):
        assert unchanged(path.read_text(), sample) == unchanged(old, sample)
    save_rig(sample.load(new), again)
    assert contents(again) == contents(new)


@each
def test_a_rig_that_did_not_change_leaves_every_byte(tmp_path: Path, sample: Sample):
    paths = sample.write(tmp_path)
    for path in paths:
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    save_rig(sample.load(paths), beside(paths))
    assert contents(beside(paths)) == contents(paths)


@pytest.mark.parametrize("name", [n for n in SAMPLES if n != "opencv xml"])
def test_only_lines_with_numbers_of_the_extrinsics_differ(tmp_path: Path, name: str):
    sample = SAMPLES[name]
    paths = sample.write(tmp_path)
    before = sample.load(paths)
    change = np.array([0, 0, 0, -0.01, 0, 0] if sample.rectified else [0.01, 0.02, 0.03, -0.01, 0.001, 0.001])
    save_rig(before.with_extrinsics(before.extrinsics + change), beside(paths))
    for old, path in zip(sample.texts, beside(paths), strict=True):
        lines = list(zip(old.splitlines(), path.read_text().splitlines(), strict=True))
        for line, other in lines:
            assert other.partition("#")[2] == line.partition("#")[2]
            assert line == other or any(digit in line for digit in "0123456789") or "dt" in line
        assert sum(line == other for line, other in lines) >= len(lines) * 0.5


@pytest.mark.parametrize("name", [n for n in SAMPLES if not SAMPLES[n].rectified])
def test_intrinsics_are_written_where_they_differ(tmp_path: Path, name: str):
    """For that camera only."""
    sample = SAMPLES[name]
    paths = sample.write(tmp_path)
    before = sample.load(paths)
    matrix = np.array(before.right.matrix) + np.diag([0.125, 0.25, 0.0])
    lens = np.concatenate([before.right.distortion[:4] * 1.5, np.zeros(before.right.distortion.size - 4)])
    rig = replace(before, right=replace(before.right, matrix=matrix, distortion=lens))
    save_rig(rig, beside(paths))
    after = sample.load(beside(paths))
    assert_same(after, rig)
    np.testing.assert_array_equal(after.left.matrix, before.left.matrix)
    assert not np.array_equal(after.right.matrix, before.right.matrix)


def test_a_lens_that_grows(tmp_path: Path):
    """A fifth coefficient, into a file with lists of four and into BoofCV's list of two radial terms."""
    four = samples.OPENCV.replace("cols: 5", "cols: 4").replace("-0.0018, 0. ]", "-0.0018 ]")
    for name, text in (("opencv yaml", four.replace("-0.002, 0. ]", "-0.002 ]")), ("boofcv", samples.BOOFCV)):
        sample = replace(SAMPLES[name], texts=(text,))
        paths = sample.write(tmp_path)
        before = sample.load(paths)
        assert before.left.distortion.size == 4
        left, right = (replace(c, distortion=np.array([*c.distortion, 0.0625])) for c in (before.left, before.right))
        rig = replace(before, left=left, right=right)
        save_rig(rig, beside(paths), overwrite=True)
        assert_same(sample.load(beside(paths)), rig)


@each
def test_another_template(tmp_path: Path, sample: Sample):
    """A rig from nowhere, written into a file that somebody has."""
    paths = sample.write(tmp_path)
    before = sample.load(paths)
    rig = StereoRig(before.left, before.right, before.extrinsics + np.array([0, 0, 0, -0.01, 0, 0]))
    new = beside(paths)
    save_rig(rig, new, template=paths, unit=sample.unit)
    assert_same(sample.load(new), rig)
    assert unchanged(new[0].read_text(), sample) == unchanged(sample.texts[0], sample)


@pytest.mark.parametrize(
    ("terms", "most"), [((0.1, 0, 0, 0, 0, 0, 0, 0), 5), ((0.1,) * 8 + (0,) * 6, 8), ((0.1,) * 4, 5)]
)
@pytest.mark.parametrize("format", ["opencv", "stereorecal", "depthai"])
def test_zero_terms_of_a_lens_are_left_out(tmp_path: Path, format: str, terms, most: int):
    """So that the digits of a repair do not depend on the format."""
    lens, paths = np.array(terms, float), new_files(tmp_path, format)
    save_rig(replace(samples.RIG, left=replace(samples.RIG.left, distortion=lens)), paths, format=format)
    found = load_rig(paths, unit=unit_of(format)).left.distortion
    assert found.size <= most
    np.testing.assert_array_equal(found, np.resize(lens, 14)[: found.size] * (np.arange(found.size) < lens.size))
    assert not np.any(lens[found.size :])
