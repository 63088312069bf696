"""The calibration of a scene: the rig, and other facts about the scene in the same file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._read_files import about
from stereorecal.io._strict_json import read_json
from stereorecal.io.formats import _stereorecal
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._numbers import image_size
from stereorecal.io.formats._read_rig import read_files
from stereorecal.io.formats._rig_file import file_of
from stereorecal.io.formats._stored_prior import KEY

_IF_MISSING = "check the path, or write a calib.json there."


@dataclass(frozen=True, eq=False)
class Calibration:
    """The content of a calibration file.

    Attributes:
        size: (width, height) of the images in pixels, as they were taken.
        rig: side by side; None if both camera matrices of a calib.json are null.
        reference: "truth" if the rig is known to be exact, such as that of a rendered scene, else "stored".
        info: the keys of a calib.json that do not describe the rig, unchanged.
    """

    size: tuple[int, int]
    rig: StereoRig | None
    reference: str = "stored"
    info: Mapping[str, Any] = field(default_factory=dict)


def load_calibration(
    paths: Sequence[Path], format: str | None = None, unit: str | None = None, hints: Hints | None = None
) -> Calibration:
    """The calibration in files as `read_files` takes them; a calib.json may lack the rig.

    Raises:
        InputError, UnsupportedModelError: as `read_files`.
    """
    if format in (None, _stereorecal.NAME) and len(paths) == 1 and paths[0].suffix == ".json":
        content = read_json(paths[0], _IF_MISSING)
        if isinstance(content, dict) and content.get("K_left", ()) is None and content.get("K_right", ()) is None:
            with about(paths[0]):
                return _of(image_size(content, "image_size"), None, content)
    rig = read_files(paths, format, unit, hints, _IF_MISSING).side_by_side()
    source = file_of(rig)
    if source is None or source.format != _stereorecal.NAME:
        return _of(rig.sizes_taken[0], rig, {})
    return _of(rig.sizes_taken[0], rig, source.documents[0].content)


def _of(size: tuple[int, int], rig: StereoRig | None, content: Mapping[str, Any]) -> Calibration:
    known = {*_stereorecal.calibration_of(None, size), "reference", KEY}
    info = {key: item for key, item in content.items() if key not in known}
    return Calibration(size, rig, "truth" if content.get("reference") == "truth" else "stored", info)


def read_json_object(path: Path) -> dict[str, Any]:
    """The keys and values of a JSON file beside the images, such as mission.json.

    Raises:
        InputError: naming the file, if it is missing, empty, truncated, not a JSON object, or contains a number that
            is not finite.
    """
    content = read_json(path, if_missing=_IF_MISSING)
    if not isinstance(content, dict):
        raise InputError(f"{path}: there is no JSON object of named values in the file; correct it.")
    return content
