"""Kalibr's camchain.yaml: cam0 is the left camera, cam1 the right one, unless others are chosen."""

import re
from collections.abc import Mapping, Sequence
from functools import reduce
from itertools import takewhile
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import (
    YAML,
    Documents,
    Format,
    Hints,
    Motion,
    Syntax,
    Target,
    inverse,
    left_to_right,
    rig_of,
)
from stereorecal.io.formats._numbers import matrix_values, numbers, optional, unpacked, value
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


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig; T_cn_cnm1 takes points of the camera before to this one, and where the file has none, the poses of both
    cameras on the IMU tell."""
    content, chain, names = documents[0].content, _cameras(documents), hints.cameras or _TABLE.names
    for key in names:
        if key not in chain:
            raise InputError(f"the chain has no {key}; give that of both cameras, calibrated together.")
    left, right = (_TABLE.camera(content, key) for key in names)
    first, last = sorted(names, key=chain.index)
    motion = _motion(content, first, last, chain[chain.index(first) + 1 : chain.index(last) + 1])
    return rig_of(left, right, motion if first == names[0] else inverse(motion))


def _motion(content: Mapping[str, Any], first: str, last: str, links: Sequence[str]) -> Motion:
    """What takes points of one camera to a later one of the chain, over the cameras after it."""
    if all(_FROM_LAST in content[name] for name in links):
        return _along(content, links)
    stated = [
        _from_imu(content, last, key) @ inverse(_from_imu(content, first, key))
        for key in (_FROM_IMU, _TO_IMU)
        if key in content[first] and key in content[last]
    ]
    if not stated:
        with about(last):
            optional(content[last], _FROM_LAST)  # refuses one that is misspelt
        raise InputError(
            f"nothing says how {first} and {last} stand to each other, neither {_FROM_LAST} of {last} nor {_FROM_IMU} "
            f"or {_TO_IMU} of both; give the result of a calibration of both."
        )
    if not np.allclose(stated[0], stated[-1], rtol=0.0, atol=_ROUNDING):
        raise InputError(f"{_FROM_IMU} and {_TO_IMU} contradict each other; remove the one that is wrong.")
    return stated[0]


def _along(content: Mapping[str, Any], links: Sequence[str]) -> Motion:
    """What takes points of the camera before these links to the last one."""
    return reduce(lambda motion, name: _pose(content, name, _FROM_LAST) @ motion, links, np.eye(4))


def _from_imu(content: Mapping[str, Any], name: str, key: str) -> Motion:
    """What takes points of the IMU to a camera."""
    stated = _pose(content, name, key)
    return stated if key == _FROM_IMU else inverse(stated)


def _pose(content: Mapping[str, Any], name: str, key: str) -> Motion:
    """A rigid motion, stated as four rows or as sixteen numbers."""
    with about(name):
        stated = unpacked(value(content[name], key))
        flat = isinstance(stated, list) and len(stated) == 16
        motion = numbers(content[name], key, (16,) if flat else (4, 4)).reshape(4, 4)
        turn = motion[:3, :3]
        if not np.allclose(turn @ turn.T, np.eye(3), rtol=0.0, atol=_ROUNDING) or np.linalg.det(turn) < 0.0:
            raise InputError(f"{key} is not a rotation (orthonormal, determinant +1) beside a translation; correct it.")
        if not np.allclose(motion[3], [0.0, 0.0, 0.0, 1.0], rtol=0.0, atol=_ROUNDING):
            raise InputError(f"the last row of {key} is not 0 0 0 1; correct it, or copy the file again.")
    return motion


def _blank(rig: StereoRig, syntax: Syntax) -> list[str]:
    """A chain of two; Kalibr's reader requires a list of coefficients of every lens."""
    (content,) = _TABLE.new_content(rig)
    left, right = ({"distortion_coeffs": [], **content[name]} for name in _TABLE.names)
    return [yaml_text({"cam0": left, "cam1": {_FROM_LAST: np.eye(4).tolist(), **right}})]


def _write(rig: StereoRig, target: Target) -> list[Values]:
    """The later one of the two cameras moves, and with it what follows it in the chain: its T_cn_cnm1, and the poses of
    all these on the IMU."""
    content, chain, values = target.documents[0].content, _cameras(target.documents), dict[Keys, Any]()
    names, motion = target.hints.cameras or _TABLE.names, left_to_right(rig)
    first, last = sorted(names, key=chain.index)
    motion = motion if first == names[0] else inverse(motion)
    links = chain[chain.index(first) + 1 : chain.index(last) + 1]
    if all(_FROM_LAST in content[name] for name in links):
        values |= matrix_values(content, (last, _FROM_LAST), motion @ inverse(_along(content, links[:-1])))
    moved = [last, *takewhile(lambda name: _FROM_LAST in content[name], chain[chain.index(last) + 1 :])]
    for key in (_FROM_IMU, _TO_IMU):
        stated = [name for name in moved if key in content[name]]
        if stated and key not in content[first]:
            raise InputError(
                f"{stated[0]} has {key} and {first} has none; remove it, since it would not fit the new rig."
            )
        to_camera = _from_imu(content, first, key) if stated else np.eye(4)
        for name in moved:
            to_camera = (motion if name == last else _pose(content, name, _FROM_LAST)) @ to_camera
            if name in stated:
                values |= matrix_values(content, (name, key), to_camera if key == _FROM_IMU else inverse(to_camera))
    for side, camera in target.cameras(rig):
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
