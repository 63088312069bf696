"""A table is a format: the one of docs/CONTRIBUTING.md, and others, read and written without a line of code more."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import samples
from every import assert_same, beside, contents
from parts_of_repairs import JSON, YAML, Format, Lens, Pose, Table, _read_rig, places
from refusals import refused

from stereorecal import UnsupportedModelError
from stereorecal.io import load_rig, save_rig

TABLE = Table(
    size="{}/resolution",
    matrix="{}/intrinsics",
    words=("{}/distortion_model",),
    lenses={"radtan": Lens("{}/coeffs"), "equidistant": Lens("{}/coeffs", "equidistant")},
    pose=Pose("{}/T_BS", inverted=True),
    names=("cam0", "cam1"),
    holder="the radtan model",
)
TABLES = {
    "of CONTRIBUTING": TABLE,
    "camera matrices": replace(TABLE, matrix="{}/K", square=True, size=places("{}", "wide high")),
    "flat matrices": replace(TABLE, matrix="{}/K", square=True, pose=Pose("{}/R", "{}/T")),
    "from left to right": replace(TABLE, pose=Pose("between/R", places("between", "x y z"), between=True)),
    "from right to left": replace(TABLE, pose=Pose("back", between=True, inverted=True)),
}


@pytest.mark.parametrize("syntax", [YAML, JSON])
@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_a_table_is_a_format(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, table: Table, syntax):
    format = Format("mine", "my own", "m", lambda document: "cam0" in document.content, table.read, syntax=syntax,
                    blank=table.blank, write=table.write)  # fmt: skip
    monkeypatch.setattr(_read_rig, "FORMATS", (format,))
    (path,) = paths = [tmp_path / f"a{next(iter(syntax))}"]
    save_rig(samples.RIG, path, format="mine")
    rig = load_rig(path)
    assert_same(rig, samples.RIG)
    save_rig(rig, beside(paths))
    assert contents(beside(paths)) == contents(paths)
    matrix = np.array(rig.right.matrix) + np.diag([0.5, 0.25, 0.0])
    changed = replace(rig, right=replace(rig.right, matrix=matrix), extrinsics=rig.extrinsics + 0.001)
    save_rig(changed, beside(paths), overwrite=True)
    assert_same(load_rig(beside(paths)), changed)
    five = replace(rig, left=replace(rig.left, distortion=np.array([*samples.LENS, 0.1])))
    refused(lambda: save_rig(five, beside(paths), overwrite=True), "the radtan model has 4 lens coefficients, and this")
    path.write_text(path.read_text().replace("radtan", "fov"))
    refused(lambda: load_rig(path), "cam0: the lens model 'fov' is not supported",
            kind=UnsupportedModelError)  # fmt: skip
