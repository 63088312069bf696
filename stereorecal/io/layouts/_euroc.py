"""EuRoC, and other data sets in the ASL format: one folder per camera."""

from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.io._scenes import remark_sizes
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._load_rig import read_files
from stereorecal.io.images._load_pairs import load_matched
from stereorecal.io.images._match_by_name import Matched, by_stem
from stereorecal.io.layouts._layout import log_of
from stereorecal.recordings import Log

LAYOUT = "EuRoC or ASL (mav0/cam0 and cam1, each with sensor.yaml and data/TIME.png)"
_LEFT, _RIGHT, _CALIBRATION, _IMAGES = "cam0", "cam1", "sensor.yaml", "data"


def recognises(folder: Path) -> bool:
    """Whether the folder is mav0 or contains it."""
    return _body(folder) is not None


def read(folder: Path, limit: int | None) -> Log:
    """The images of cam0 (left) and cam1 (right) with equal time stamps; one that only one camera took is left out."""
    body = _body(folder) or folder
    matched = _same_time(body / _LEFT / _IMAGES, body / _RIGHT / _IMAGES)
    files = [body / side / _CALIBRATION for side in (_LEFT, _RIGHT)]
    rig = read_files(files, "euroc")
    sizes = rig.sizes_taken
    pairs = load_matched(matched, limit, sizes=sizes)
    if sizes[0] != sizes[1]:
        rig = read_files(files, "euroc", hints=Hints(common_size=True))
        remark_sizes(str(folder), sizes)
    return log_of(folder, [(folder, rig, pairs)])


def _body(folder: Path) -> Path | None:
    return next((body for body in (folder / "mav0", folder) if (body / _LEFT / _IMAGES).is_dir()), None)


def _same_time(left: Path, right: Path) -> Matched:
    left_files, right_files = by_stem(left), by_stem(right)
    matched = [(path, right_files[time]) for time, path in left_files.items() if time in right_files]
    if not matched:
        raise InputError(f"{left}: no image in it has the same time (file name) as one in {right}; check both.")
    return matched
