"""ROS camera_info, one file for each camera (YAML, or the message as echo prints it), or both cameras in one file:
messages that were printed one after the other, or ost.txt, which camera_calibration writes beside its YAML files (read
only). The extrinsics are implied by the rectification."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stereorecal._arrays import Vec3
from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import YAML, Cameras, Documents, Format, Hints, Syntax
from stereorecal.io.formats._kitti import camera_and_place
from stereorecal.io.formats._numbers import (
    Array,
    check_no_lens,
    coefficients,
    image_size,
    matrix_values,
    numbers,
    size_of,
    unsupported,
    value,
)
from stereorecal.io.formats._poses import pose_of_rectified, rig_of
from stereorecal.io.formats._rectification_matrices import RectifyOptions, options_of, rectification_of
from stereorecal.io.formats._table import yaml_text
from stereorecal.io.formats.text._document import Document
from stereorecal.io.formats.text._nodes import DOCUMENTS, Keys, Values, at

_ROLES = ("width", "height", "matrix", "lens", "rotation", "projection")
_SPELLINGS: list[dict[str, str]] = [  # of files, and of the messages of ROS 1 and ROS 2
    dict(zip(_ROLES, keys.split(), strict=True))
    for keys in (
        "image_width image_height camera_matrix distortion_coefficients rectification_matrix projection_matrix",
        "width height K D R P",
        "width height k d r p",
        "width height camera_matrix distortion rectification projection",  # of ost.txt, with spaces for underscores
    )
]
_EQUIDISTANT = ("equidistant", "fisheye")
_MODELS = ("plumb_bob", "rational_polynomial", "", "none", *_EQUIDISTANT)


@dataclass(frozen=True)
class _Part:
    """What a document says of one camera."""

    where: str  # the name of the document
    content: Mapping[str, Any]  # as if it said nothing else
    keys: Mapping[str, str]  # the keys that it has, by what they hold
    places: tuple[Keys, ...] = ((),)  # of the content in the whole; several, if its message was printed several times
    name: str = ""  # of the camera

    @property
    def said(self) -> list[Any]:
        """What is equal for messages of one calibration."""
        return [self.content.get(key) for key in ("distortion_model", *self.keys.values())]


def _parts_of(document: Document) -> list[_Part]:
    """The different cameras in a document: of one message or file, of several messages, or of an ost.txt."""
    several, found = document.content.get(DOCUMENTS), list[_Part]()
    maps = [((DOCUMENTS, number), one) for number, one in enumerate(several)] if isinstance(several, list) else []
    for place, content in maps or [((), document.content)]:
        keys = _spelling(content) if isinstance(content, Mapping) else None
        if keys is None:
            continue
        frame = at(content, ("header", "frame_id"))
        part = _Part(document.name, content, keys, (place,), str(content.get("camera_name") or frame or ""))
        known = next((number for number, other in enumerate(found) if other.said == part.said), None)
        if known is None:
            found.append(part)
        else:
            found[known] = replace(found[known], places=(*found[known].places, place))
    return found


def _chosen(documents: Documents, hints: Hints) -> list[_Part]:
    """The left and the right camera: of one file the first two, unless the hints name them; of two files the one camera
    of each, or the file itself, whose reader says what it lacks."""
    parts = [_parts_of(document) for document in documents]
    if len(parts) == 1:
        names = _camera_names(documents)
        if len(names) > 2:
            raise InputError(
                f"it has {len(names)} calibrations that differ ({', '.join(names)}); keep those of the left and the "
                "right camera."
            )
        if len(names) < 2:
            raise IndexError  # not arranged as this format is
        return [parts[0][names.index(name)] for name in hints.cameras or names]
    for document, found in zip(documents, parts, strict=True):
        if len(found) > 1:
            raise InputError(
                f"{document.name}: it holds {len(found)} calibrations that differ; keep one of each camera: in a file "
                "for each, or both in one, which is given alone."
            )
    return [
        found[0] if found else _Part(document.name, document.content, _SPELLINGS[0])
        for document, found in zip(documents, parts, strict=True)
    ]


def _camera_names(documents: Documents) -> tuple[str, ...]:
    """The names of the cameras in one file, or their numbers where these are not different names."""
    names = tuple(part.name for part in _parts_of(documents[0]))
    return names if all(names) and len(set(names)) == len(names) else tuple(map(str, range(len(names))))


def _spelling(content: Mapping[str, Any]) -> dict[str, str] | None:
    """The keys that a camera has, by what they hold; None if it has those of none."""
    for keys in _SPELLINGS:
        needed = {keys[role] for role in ("matrix", "rotation", "projection")}
        # K, R and P alone may be anybody's.
        if needed | ({"distortion_model"} if len(keys["matrix"]) == 1 else set()) <= content.keys():
            return keys
    return None


def _read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of a left and a right camera."""
    parts = _chosen(documents, hints)
    (left, to_left, left_place), (right, to_right, place) = map(_camera, parts)
    with about(" and ".join(dict.fromkeys(part.where for part in parts))):
        if np.array_equal(place, left_place):
            raise InputError(
                f"{parts[1].keys['projection']} has no baseline (its fourth column is the same in both files); "
                "calibrate the two as stereo."
            )
        return rig_of(left, right, pose_of_rectified((to_left, left_place), (to_right, place)))


def _camera(part: _Part) -> tuple[Camera, Array, Vec3]:
    """A camera, the rotation that rectifies it, and t of its projection matrix K [I | t]."""
    content, names = part.content, part.keys
    with about(part.where):
        size = image_size(content, names["width"], names["height"])
        lens = numbers(content, names["lens"], (-1,))
        # ROS itself reads a file without a model as plumb_bob; four coefficients could be equidistant.
        unsaid = "distortion_model" not in content and lens.size in (5, 8)
        stated = "plumb_bob" if unsaid else value(content, "distortion_model") or ""
        if stated not in _MODELS:
            raise unsupported(stated)
        check_no_lens(stated, lens)
        model = "equidistant" if stated in _EQUIDISTANT else Camera.model
        matrix, rotation = (numbers(content, names[role], (3, 3)) for role in ("matrix", "rotation"))
        projection = numbers(content, names["projection"], (3, 4))
        if not np.any(matrix):
            raise InputError(f"{names['matrix']} is 0: this camera is not calibrated; calibrate it.")
        if not np.any(rotation):  # as ZED's driver leaves it for its rectified images
            if np.any(lens) or not np.array_equal(matrix, projection[:, :3]):
                raise InputError(
                    f"{names['rotation']} is 0, and the images are not rectified; calibrate the two as stereo."
                )
            rotation = np.eye(3)
        camera = Camera(size, matrix, lens, model=model)
        if not np.any(projection):
            raise InputError(f"{names['projection']} is 0; calibrate the two as stereo.")
        return camera, rotation, camera_and_place(content, names["projection"], size)[1]


def _blank(rig: StereoRig, syntax: Syntax) -> list[str]:
    """Both files; their numbers differ, as equal cameras in one file are taken for one."""
    texts = []
    for number, (name, camera) in enumerate((("left", rig.left), ("right", rig.right))):
        model, lens = _lens(camera)
        size = {"image_width": camera.size[0], "image_height": camera.size[1], "camera_name": name}
        lenses = {"distortion_model": model, "distortion_coefficients": _filled(1, lens.size, number)}
        rectified = {"rectification_matrix": _filled(3, 3, number), "projection_matrix": _filled(3, 4, number)}
        texts.append(yaml_text({**size, "camera_matrix": _filled(3, 3, number), **lenses, **rectified}))
    return texts


def _filled(rows: int, columns: int, number: float) -> dict[str, Any]:
    return {"rows": rows, "cols": columns, "data": [float(number)] * rows * columns}


def _write(rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> Sequence[Values]:
    """What to write for each camera, everywhere where it is printed: rectification and projection matrices, with the
    files' own options; intrinsics of cameras that have changed."""
    parts = _chosen(documents, hints)
    P1, P2 = (numbers(part.content, part.keys["projection"], (3, 4)) for part in parts)
    options = options_of(lambda: _read(documents, hints), P1, P2, RectifyOptions())
    made = rectification_of(rig, options)
    found = [dict[Keys, Any]() for _ in documents]
    for side, part in enumerate(parts):
        content, names, values = part.content, part.keys, dict[Keys, Any]()
        arrays = {names["rotation"]: made[f"R{side + 1}"], names["projection"]: made[f"P{side + 1}"]}
        if side in changed:
            model, lens = _lens(changed[side], size_of(content, (names["lens"],)))
            arrays[names["matrix"]] = np.asarray(changed[side].matrix)
            if np.any(lens) or content.get("distortion_model", model) not in (None, "", "none"):
                arrays[names["lens"]] = lens
                if "distortion_model" in content and model != "equidistant":  # which has another name, fisheye, too
                    values[("distortion_model",)] = model
        for key, array in arrays.items():
            values.update(matrix_values(content, (key,), array))
        found[-side] |= {(*place, *keys): value for place in part.places for keys, value in values.items()}
    return found


def _lens(camera: Camera, least: int = 5) -> tuple[str, Array]:
    """The model and its coefficients: as many as the file has or more, up to ROS's 8 unless it has more."""
    lens = coefficients(camera, (4, 5, 8) if least <= 8 else (12, 14), "ROS", "opencv or stereorecal", least)
    return camera.model if camera.model != Camera.model else _MODELS[lens.size >= 8], lens


FORMAT = Format(
    "ros",
    "ROS camera_info (left and right YAML file, or the messages as `rostopic echo` prints them)",
    "m",
    lambda document: bool(_parts_of(document)),
    _read,
    files=2,
    syntax=YAML,
    blank=_blank,
    write=_write,
)
IN_ONE_FILE = Format(
    "camera_info",
    "ROS camera_info of both cameras in one file (echoed messages, ost.txt)",
    "m",
    lambda document: len(_parts_of(document)) > 1,
    _read,
    cameras=_camera_names,
    syntax=YAML,
    blank=lambda rig, syntax: ("---\n".join(_blank(rig, syntax)),),
    write=_write,
)
