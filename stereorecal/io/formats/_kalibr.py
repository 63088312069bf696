"""Kalibr's camchain.yaml: cam0 is the left camera, cam1 the right one, unless others are chosen."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import YAML, Cameras, Documents, Format, Hints, Syntax
from stereorecal.io.formats._numbers import matrix_values, optional
from stereorecal.io.formats._poses import Link, Motion, left_to_right, motions_from, moved, rig_of, stated_pose
from stereorecal.io.formats._table import Lens, Table, yaml_text
from stereorecal.io.formats.text._nodes import Keys, Values

_FROM_LAST, _FROM_IMU, _TO_IMU = "T_cn_cnm1", "T_cam_imu", "T_imu_cam"
_ROUNDING = 1e-3  # of the entries of a pose (metres, in its last column), as people round them
_TERMS = "{}/distortion_coeffs"
_TABLE = Table(
    size="{}/resolution",
    matrix="{}/intrinsics",
    words=("{}/camera_model", "{}/distortion_model"),
    lenses={
        "pinhole radtan": Lens(_TERMS),
        "pinhole equidistant": Lens(_TERMS, "equidistant"),
        "pinhole none": Lens(_TERMS, becomes="radtan"),
        "omni radtan": Lens(_TERMS, "omni", before=1),
        "omni none": Lens(_TERMS, "omni", before=1, becomes="radtan"),
        "ds none": Lens((), "ds", before=2),
        "eucm none": Lens((), "eucm", before=2),
    },
    names=("cam0", "cam1"),
    holder="Kalibr's radtan",
)


def _cameras(documents: Documents) -> tuple[str, ...]:
    """The names of the cameras, along the chain."""
    content = documents[0].content
    named = (key for key in content if re.fullmatch(r"cam\d+", str(key)) and isinstance(content[key], Mapping))
    return tuple(sorted(named, key=lambda name: int(name[3:])))


def _links(content: Mapping[str, Any], chain: Sequence[str], *keys: str) -> list[Link]:
    """The poses under some keys of cameras that stand in a row: on the camera before, or on the IMU."""
    return [
        Link(name, before if key == _FROM_LAST else "imu", _pose(content, name, key), key == _TO_IMU, key)
        for key in keys
        for before, name in zip(("", *chain), chain, strict=False)
        if key in content[name] and (before or key != _FROM_LAST)
    ]


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig; where the chain between its cameras has a gap, their poses on the IMU tell."""
    content, chain, names = documents[0].content, _cameras(documents), hints.cameras or _TABLE.names
    for key in names:
        if key not in chain:
            raise InputError(f"the chain has no {key}; give that of both cameras, calibrated together.")
    left, right = (_TABLE.camera(content, key) for key in names)
    first, last = sorted(names, key=chain.index)
    motion = motions_from(names[0], _links(content, chain, _FROM_LAST)).get(names[1])
    if motion is None:
        ways = (_links(content, (last, first), key) for key in (_FROM_IMU, _TO_IMU))
        stated = [motions_from(names[0], links)[names[1]] for links in ways if len(links) == 2]
        if not stated:
            with about(last):
                optional(content[last], _FROM_LAST)  # refuses one that is misspelt
            raise InputError(
                f"nothing says how {first} and {last} stand to each other, neither {_FROM_LAST} of {last} nor "
                f"{_FROM_IMU} or {_TO_IMU} of both; give the result of a calibration of both."
            )
        if not np.allclose(stated[0], stated[-1], rtol=0.0, atol=_ROUNDING):
            raise InputError(f"{_FROM_IMU} and {_TO_IMU} contradict each other; remove the one that is wrong.")
        motion = stated[0]
    return rig_of(left, right, motion)


def _pose(content: Mapping[str, Any], name: str, key: str) -> Motion:
    with about(name):
        return stated_pose(content[name], key)


def _blank(rig: StereoRig, syntax: Syntax) -> list[str]:
    """A chain of two; Kalibr's reader requires a list of coefficients of every lens."""
    (content,) = _TABLE.new_content(rig)
    left, right = ({"distortion_coeffs": [], **content[name]} for name in _TABLE.names)
    return [yaml_text({"cam0": left, "cam1": {_FROM_LAST: np.eye(4).tolist(), **right}})]


def _write(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> list[Values]:
    """What stands on the camera that moves follows it: its T_cn_cnm1, and the poses of all these on the IMU."""
    content, chain, values = documents[0].content, _cameras(documents), dict[Keys, Any]()
    names = hints.cameras or _TABLE.names
    first = min(names, key=chain.index)
    for link, motion in moved(_links(content, chain, _FROM_LAST, _FROM_IMU, _TO_IMU), *names, left_to_right(rig)):
        if link.key != _FROM_LAST and link.key not in content[first]:
            raise InputError(
                f"{link.camera} has {link.key} and {first} has none; remove it, since it would not fit the new rig."
            )
        values |= matrix_values(content, (link.camera, link.key), motion)
    for side, camera in changed.items():
        values |= _TABLE.values(content, names[side], camera)
    return [values]


FORMAT = Format(
    "kalibr",
    "Kalibr's camchain (YAML with cam0, cam1, and T_cn_cnm1, T_cam_imu or T_imu_cam)",
    "m",
    lambda document: any(isinstance(document.content.get(key), Mapping) for key in _TABLE.names),
    _read,
    cameras=_cameras,
    syntax=YAML,
    blank=_blank,
    write=_write,
)
