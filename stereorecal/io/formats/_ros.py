"""ROS camera_info, one file for each camera: YAML, or the message as echo prints it; the extrinsics are implied by the
rectification."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stereorecal._arrays import Vec3
from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats._kitti_rectified import in_projection
from stereorecal.io.formats._lens_numbers import check_held, check_model, check_no_lens, coefficients
from stereorecal.io.formats._matrix_values import matrix_values, size_of
from stereorecal.io.formats._numbers import numbers, pixels, value
from stereorecal.io.formats._rectification_matrices import Array, RectifyOptions, options_of, rectification_of
from stereorecal.io.formats._rigid_motions import pose, rig_of
from stereorecal.io.formats.text._document import Document, Syntax
from stereorecal.io.formats.text._keys import Keys
from stereorecal.io.formats.text._yaml import DOCUMENTS

NAME = "ros"
ABOUT = "ROS camera_info (left and right YAML file, or the messages as `rostopic echo` prints them)"
SYNTAX = {".yaml": Syntax.YAML, ".yml": Syntax.YAML}
FILES = 2
UNIT = "m"

_ROLES = ("width", "height", "matrix", "lens", "rotation", "projection")
_SPELLINGS = (  # of files, and of the messages of ROS 1 and ROS 2
    "image_width image_height camera_matrix distortion_coefficients rectification_matrix projection_matrix",
    "width height K D R P",
    "width height k d r p",
    "width height camera_matrix distortion rectification projection",  # of ost.txt, with spaces for underscores
)
_EQUIDISTANT = ("equidistant", "fisheye")
_MODELS = ("plumb_bob", "rational_polynomial", "", "none", *_EQUIDISTANT)
_RECTIFY = RectifyOptions(alpha=0.0)  # of the camera_calibration package
_BLANK = """\
image_width: {width}
image_height: {height}
camera_name: {name}
camera_matrix:
  rows: 3
  cols: 3
  data: {nine}
distortion_model: {model}
distortion_coefficients:
  rows: 1
  cols: {count}
  data: {lens}
rectification_matrix:
  rows: 3
  cols: 3
  data: {nine}
projection_matrix:
  rows: 3
  cols: 4
  data: {twelve}
"""


@dataclass(frozen=True)
class Part:
    """What a document says of one camera.

    Attributes:
        document: as if it said nothing else.
        places: where that stands in the whole; several, if its message was printed several times.
        name: of the camera.
    """

    document: Document
    places: tuple[Keys, ...]
    name: str


def parts_of(document: Document) -> list[Part]:
    """The different cameras in a document: of one message or file, of several messages, or of an ost.txt."""
    several, found = document.content.get(DOCUMENTS), list[tuple[Part, list[Any]]]()
    maps = [((DOCUMENTS, at), one) for at, one in enumerate(several)] if isinstance(several, list) else []
    if document.syntax is Syntax.SECTIONS:
        sections = {key: one for key, one in document.content.items() if isinstance(one, Mapping)}
        image = sections.pop("image", {})
        maps = [((key,), _with_underscores({**image, **one})) for key, one in sections.items()]
    for place, content in maps or [((), document.content)]:
        part = replace(document, content=content)
        said = [content.get(key) for key in ("distortion_model", *(_spelling(part) or "").split())]
        known = next((one for one in found if one[1] == said), None) if _spelling(part) else None
        if known is not None:
            found[found.index(known)] = (Part(known[0].document, (*known[0].places, place), known[0].name), said)
        elif _spelling(part):
            header = content.get("header")
            frame = header.get("frame_id") if isinstance(header, Mapping) else None
            name = content.get("camera_name") or frame or (place[0] if len(place) == 1 else "")
            found.append((Part(part, (place,), str(name)), said))
    return [part for part, _ in found]


def _with_underscores(content: Mapping[str, Any]) -> dict[str, Any]:
    return {key.replace(" ", "_"): item for key, item in content.items()}


def can_read(documents: Documents) -> bool:
    """Whether both files have what only ROS has."""
    return len(documents) == 2 and all(map(parts_of, documents))


def _only(document: Document) -> Part:
    """The one camera of a file, or the file itself, whose reader says what it lacks.

    Raises:
        InputError: if there are several.
    """
    parts = parts_of(document) or [Part(document, ((),), "")]
    if len(parts) > 1:
        raise InputError(
            f"{document.name}: it holds {len(parts)} calibrations that differ; keep one of each camera: in a file for "
            "each, or both in one, which is given alone."
        )
    return parts[0]


def _spelling(document: Document) -> str | None:
    """The keys that a file has; None if it has those of none."""
    for keys in _SPELLINGS:
        _, _, matrix, _, *rectified = keys.split()
        more = {"distortion_model"} if len(matrix) == 1 else set()  # K, R and P alone may be anybody's
        if {matrix, *rectified, *more} <= document.content.keys():
            return keys
    return None


def _names(document: Document) -> dict[str, str]:
    """The keys of a file by what they hold; those of camera_info YAML if it has the keys of none."""
    return dict(zip(_ROLES, (_spelling(document) or _SPELLINGS[0]).split(), strict=True))


def _matrix(document: Document, key: str, shape: tuple[int, int]) -> Array:
    stated = document.content.get(key)
    flat = isinstance(stated, list) and not any(isinstance(item, list) for item in stated)
    return numbers(document.content, key, (shape[0] * shape[1],) if flat else shape).reshape(shape)


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of ROS camera_info files: R = R_right^T R_left, and T = R_right^T (t_right - t_left), P = K [I | t].

    KITTI's cameras have x, y and z; cameras one above the other, y.
    """
    return rig_of_parts(*(_only(document).document for document in documents))


def rig_of_parts(*documents: Document) -> StereoRig:
    """The rig of two cameras, left before right."""
    (left, to_left, left_place), (right, to_right, place) = (_camera(document) for document in documents)
    with about(" and ".join(dict.fromkeys(document.name for document in documents))):
        if np.array_equal(place, left_place):
            raise InputError(
                f"{_names(documents[1])['projection']} has no baseline (its fourth column is the same in both files); "
                "calibrate the two as stereo."
            )
        return rig_of(left, right, pose(to_right.T @ to_left, to_right.T @ (place - left_place)))


def _camera(document: Document) -> tuple[Camera, Array, Vec3]:
    """A camera, the rotation that rectifies it, and t of its projection matrix K [I | t]."""
    content, names = document.content, _names(document)
    with about(document.name):
        size = pixels(content, names["width"]), pixels(content, names["height"])
        lens = numbers(content, names["lens"], (-1,))
        # ROS itself reads a file without a model as plumb_bob; four coefficients could be equidistant.
        unsaid = "distortion_model" not in content and lens.size in (5, 8)
        stated = "plumb_bob" if unsaid else value(content, "distortion_model") or ""
        check_model(stated, _MODELS)
        check_no_lens(stated, lens)
        model = "equidistant" if stated in _EQUIDISTANT else Camera.model
        matrix, rotation = (_matrix(document, names[role], (3, 3)) for role in ("matrix", "rotation"))
        projection = _matrix(document, names["projection"], (3, 4))
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
        with about(names["projection"]):
            _, place = in_projection(projection, size)
    return camera, rotation, place


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """Both files."""
    texts = []
    for name, camera in (("left", rig.left), ("right", rig.right)):
        model, lens = _lens(camera)
        zeros = {"nine": [0.0] * 9, "twelve": [0.0] * 12, "lens": [0.0] * lens.size, "count": lens.size}
        texts.append(_BLANK.format(width=camera.size[0], height=camera.size[1], name=name, model=model, **zeros))
    return tuple(texts)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """ROS camera_info files: rectification and projection matrices, with the files' own options; intrinsics of the
    cameras of the target."""
    parts = [_only(document) for document in target.documents]
    values = values_of(rig, target, *parts)
    return tuple(document.with_values(new) for document, new in zip(target.documents, values, strict=True))


def values_of(rig: StereoRig, target: Target, left: Part, right: Part) -> list[dict[Keys, Any]]:
    """What to write for the left and for the right camera, everywhere where it is printed."""
    documents = left.document, right.document
    P1, P2 = (_matrix(document, _names(document)["projection"], (3, 4)) for document in documents)
    options = options_of(rig_of_parts(*documents), P1, P2, _RECTIFY) if np.any(P1) else _RECTIFY
    made = rectification_of(rig, options)
    found = []
    for side, (part, camera, wanted) in enumerate(
        ((left, rig.left, target.left), (right, rig.right, target.right)), start=1
    ):
        content, names, values = part.document.content, _names(part.document), dict[Keys, Any]()
        arrays = {names["rotation"]: made[f"R{side}"], names["projection"]: made[f"P{side}"]}
        if wanted:
            model, lens = _lens(camera, size_of(content, (names["lens"],)))
            arrays[names["matrix"]] = np.asarray(camera.matrix)
            if camera.model == "equidistant":
                arrays[names["lens"]] = lens
            elif np.any(lens) or content.get("distortion_model", model) not in (None, "", "none"):
                arrays[names["lens"]] = lens
                values |= {("distortion_model",): model} if "distortion_model" in content else {}
        for key, array in arrays.items():
            values.update(matrix_values(content, (key,), array))
        found.append({(*place, *keys): value for place in part.places for keys, value in values.items()})
    return found


def _lens(camera: Camera, least: int = 5) -> tuple[str, Array]:
    """The model and its coefficients: as many as the file has or more, up to ROS's 8 unless it has more."""
    check_held(camera, (Camera.model, "equidistant"), "ROS")
    if camera.model == "equidistant":
        return camera.model, np.asarray(camera.distortion)
    counts = [count for count in ((4, 5, 8) if least <= 8 else (12, 14)) if count >= least]
    lens = coefficients(camera, counts, "ROS", "opencv or stereorecal")
    return "plumb_bob" if lens.size < 8 else "rational_polynomial", lens
