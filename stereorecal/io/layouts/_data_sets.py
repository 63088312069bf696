"""Public data sets: EuRoC, and others in the ASL format; and KITTI's: raw data, rectified or not, odometry, and the
stereo benchmarks of 2012 and 2015."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig, same_rig
from stereorecal.io._read_files import about, check_there, read_text
from stereorecal.io._scenes import Calibration, fitting, remark_sizes
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._load_rig import read_files
from stereorecal.io.formats._read_rig import at_common_size
from stereorecal.io.formats.text._document import Syntax, read_document
from stereorecal.io.images._frame_source import pairs_by_time
from stereorecal.io.images._image_files import natural_order
from stereorecal.io.images._load_pairs import load_matched
from stereorecal.io.images._match_by_name import Matched, by_stem, match_keys
from stereorecal.io.layouts._own_folders import folder_name
from stereorecal.recordings import LazyPairs, Log, Mission

Sequence = tuple[Path, StereoRig, LazyPairs]  # its folder, the rig, the pairs
_Sides = tuple[str, str]  # the folders of the left and the right camera
_IF_MISSING = "download {} from KITTI's page and unpack it over the images."


def log_of(folder: Path, sequences: Iterable[Sequence]) -> Log:
    """The log of the sequences in a folder, each named after its own folder.

    A single calibration is named "stored"; of several, each is named after the first sequence that has it.

    Raises:
        InputError: if there is no sequence, or the first images of one do not fit its calibration; of others, this is
            said when they are read.
    """
    calibrations: dict[str, StereoRig] = {}
    missions: list[Mission] = []
    for place, rig, pairs in sequences:
        name = folder_name(folder) if place == folder else place.name
        calibration = next((known for known, other in calibrations.items() if same_rig(rig, other)), name)
        calibrations.setdefault(calibration, rig)
        missions.append(Mission(name, calibration, fitting(place, Calibration(rig), pairs)))
    if len(calibrations) == 1:
        calibrations = {"stored": next(iter(calibrations.values()))}
        missions = [replace(mission, calibration="stored") for mission in missions]
    return Log(folder_name(folder), calibrations, tuple(missions))


@dataclass(frozen=True)
class _DataSet:
    """One of them, as `Layout` has it: whether a folder holds it, and the sequences in the folder."""

    LAYOUT: str
    recognises: Callable[[Path], bool]
    sequences: Callable[[Path, int | None], Iterable[Sequence]]

    def read(self, folder: Path, limit: int | None) -> Log:
        return log_of(folder, self.sequences(folder, limit))


def _places_in(folder: Path, pattern: str, choices: Iterable[_Sides]) -> list[Path]:
    """The folder, if it has images of such cameras, else those below it that have some, in natural order."""
    sides = [side for sides in choices for side in sides]
    places = [place for place in (folder, *folder.glob(pattern)) if any((place / side).is_dir() for side in sides)]
    return [folder] if folder in places else natural_order(places)


def _sides_in(folder: Path, choices: Iterable[_Sides]) -> _Sides:
    """The first choice whose left and right folder both exist."""
    for sides in choices:
        if all((folder / side).is_dir() for side in sides):
            return sides
    wanted = ", or ".join(f"{left} and {right}" for left, right in choices)
    raise InputError(f"{folder}: both cameras are needed, the folders {wanted}; unpack the images of the other one.")


# --- EuRoC: a folder for each camera

_SENSOR = "sensor.yaml"


def _body(folder: Path) -> Path | None:
    """mav0, which the folder is or contains."""
    return next((body for body in (folder / "mav0", folder) if (body / "cam0/data").is_dir()), None)


def _euroc(folder: Path, limit: int | None) -> Iterator[Sequence]:
    """The images of cam0 (left) and cam1 (right) with equal time stamps; one that only one camera took is left out."""
    left, right = ((_body(folder) or folder) / side for side in ("cam0", "cam1"))
    left_files, right_files = by_stem(left / "data"), by_stem(right / "data")
    matched = [(path, right_files[time]) for time, path in left_files.items() if time in right_files]
    if not matched:
        raise InputError(
            f"{left / 'data'}: no image in it has the same time (file name) as one in {right / 'data'}; check both."
        )
    rig = read_files([left / _SENSOR, right / _SENSOR], "euroc")
    pairs = load_matched(matched, limit, sizes=rig.sizes_taken)
    remark_sizes(str(folder), rig.sizes_taken)
    yield folder, at_common_size(rig), pairs


EUROC = _DataSet(
    "EuRoC or ASL (mav0/cam0 and cam1, each with sensor.yaml and data/TIME.png)",
    lambda folder: _body(folder) is not None,
    _euroc,
)

# --- KITTI odometry

_ODOMETRY = ("sequences/*", (("image_0", "image_1"), ("image_2", "image_3")))  # grey before colour


def _odometry(folder: Path, limit: int | None) -> Iterator[Sequence]:
    """The sequences whose images have been unpacked."""
    for place in _places_in(folder, *_ODOMETRY):
        left, right = _sides_in(place, _ODOMETRY[1])
        matched = match_keys(by_stem(place / left), by_stem(place / right))
        pairs = load_matched(matched, limit, _read_times(place / "times.txt", len(matched)))
        hints = Hints(size=pairs[0].size, cameras=(f"P{left[-1]}", f"P{right[-1]}"))
        check_there(place / "calib.txt", _IF_MISSING.format("data_odometry_calib.zip"))
        yield place, read_files([place / "calib.txt"], "kitti-odometry", hints=hints), pairs


def _read_times(path: Path, pairs: int) -> list[float] | None:
    """Seconds, a line for each image; None if the file is missing, or not of these images."""
    try:
        times = [float(line) for line in read_text(path).split()] if path.is_file() else []
    except ValueError:
        return None
    return times if len(times) == pairs and np.isfinite(times).all() else None


KITTI_ODOMETRY = _DataSet(
    "KITTI odometry (sequences/NN), or one sequence of it (calib.txt, image_0 and image_1, or image_2 and image_3)",
    lambda folder: bool(_places_in(folder, *_ODOMETRY)),
    _odometry,
)

# --- KITTI raw data

_RAW = ("*_drive_*", (("image_00", "image_01"), ("image_02", "image_03")))
_OF_DAY, _TIMES, _RECTIFIED, _AS_TAKEN = "calib_cam_to_cam.txt", "timestamps.txt", "_sync", "_extract"
# The cameras are triggered together ten times a second (KITTI's raw data paper): images less than half a period apart
# are of the same trigger.
_SAME_SHOT = 0.05  # seconds
_BEFORE = np.datetime64("2011-01-01")  # all drives: fewer digits than since 1970


def _raw(folder: Path, limit: int | None) -> Iterator[Sequence]:
    """The drives of a day, or one drive, whose calibration lies in the folder above.

    `_sync` images are rectified: the rig comes from P_rect and has no rotation or distortion. `_extract` images are
    raw: the rig comes from K, D, R and T. Their numbers do not correspond between cameras, so they are paired by time,
    and one that only one camera took is left out."""
    for drive in _places_in(folder, *_RAW):
        day, name = drive.resolve().parent, drive.resolve().name
        left, right = _sides_in(drive, _RAW[1])
        rectified = name.endswith(_RECTIFIED)
        if not rectified and not name.endswith(_AS_TAKEN):
            raise InputError(
                f"{drive}: the name does not say whether the images are rectified; rename the folder to end in "
                f"{_RECTIFIED} (rectified) or {_AS_TAKEN}."
            )
        hints = Hints(cameras=(left[-2:], right[-2:]), rectified=rectified)
        check_there(day / _OF_DAY, _IF_MISSING.format(f"{day.name}_calib.zip"))
        rig = read_files([day / _OF_DAY], "kitti-raw", hints=hints)
        if rectified:
            matched = match_keys(by_stem(drive / left / "data"), by_stem(drive / right / "data"))
        else:
            matched = _match_by_time(drive / left, drive / right)
        yield drive, rig, load_matched(matched, limit, _seconds(drive / left, matched))


def _match_by_time(left: Path, right: Path) -> Matched:
    lefts, rights = _shots(left), _shots(right)
    with about(f"{left} and {right}"):
        found = pairs_by_time(np.array([*lefts.values()]), np.array([*rights.values()]), _SAME_SHOT)
    files, others = [*lefts], [*rights]
    return [(files[one], others[other]) for one, other in found]


def _seconds(camera: Path, matched: Matched) -> list[float] | None:
    """When the left images were taken; None if the file of their times is missing."""
    if not (camera / _TIMES).is_file():
        return None
    shots = _shots(camera)
    start = next(iter(shots.values()))
    return [shots[path] - start for path, _ in matched]


def _shots(camera: Path) -> dict[Path, float]:
    """The images of a camera and their times: the number in an image's name is its line in timestamps.txt, from 0."""
    files, path = by_stem(camera / "data"), camera / _TIMES
    check_there(path, "add it.")
    lines = read_text(path).split("\n")
    try:
        times = np.array([lines[int(stem)].strip() for stem in files], "datetime64[ns]")
    except (IndexError, ValueError):
        times = np.array(["NaT"], "datetime64[ns]")
    if np.isnat(times).any():
        raise InputError(f"{path}: not every image in data has a time in this file; copy or unpack it again.")
    return dict(zip(files.values(), ((times - _BEFORE) / np.timedelta64(1, "s")).tolist(), strict=True))


KITTI_RAW = _DataSet(
    "KITTI raw data (DATE/calib_cam_to_cam.txt, DATE/DATE_drive_NNNN_sync or _extract), or one drive of it",
    lambda folder: (folder / _OF_DAY).is_file() or bool(_places_in(folder, *_RAW)),
    _raw,
)

# --- KITTI stereo 2012 and 2015: single rectified frames, each with a calibration file of its own

_BENCHMARK = "_10"  # the benchmark's frame of each scene; "_11" is the next one
_OF_2012 = ("calib", "kitti-odometry", "data_stereo_flow_calib.zip")
_OF_2015 = ("calib_cam_to_cam", "kitti-raw", "data_scene_flow_calib.zip")
# By the folders of images, grey before colour: the folder of calibrations, their format and download; the names of the
# cameras in there, and the keys of their projection matrices.
_KINDS: dict[_Sides, tuple[tuple[str, str, str], _Sides, _Sides]] = {
    ("image_0", "image_1"): (_OF_2012, ("P0", "P1"), ("P0", "P1")),
    ("colored_0", "colored_1"): (_OF_2012, ("P2", "P3"), ("P2", "P3")),
    ("image_2", "image_3"): (_OF_2015, ("02", "03"), ("P_rect_02", "P_rect_03")),
}


def _stereo(folder: Path, limit: int | None) -> Iterator[Sequence]:
    """The frames of the benchmark. Those with equal calibrations, taken on one day, are one mission, which is named
    after the number of its first frame."""
    sides = _sides_in(folder, _KINDS)
    (calibrations, format, archive), cameras, projections = _KINDS[sides]
    days: dict[object, tuple[Path, list[tuple[Path, Path]]]] = {}
    for left, right in match_keys(by_stem(folder / sides[0]), by_stem(folder / sides[1])):
        if left.stem.endswith(_BENCHMARK):
            path = folder / calibrations / f"{left.stem.removesuffix(_BENCHMARK)}.txt"
            check_there(path, _IF_MISSING.format(archive))
            content = read_document(path, Syntax.COLONS).content
            # The projections distinguish the days; the time of the calibration does not matter.
            values = tuple(tuple(content.get(key, ())) for key in projections)
            days.setdefault(values, (path, []))[1].append((left, right))
    for path, matched in days.values():
        pairs = load_matched(matched, limit)
        hints = Hints(size=pairs[0].size, cameras=cameras, rectified=True)
        yield folder / path.stem, read_files([path], format, hints=hints), pairs


KITTI_STEREO = _DataSet(
    "KITTI stereo 2012 or 2015 (the folder training or testing, with NNNNNN_10.png and the calibration files)",
    lambda folder: any(any((folder / left).glob(f"*{_BENCHMARK}.png")) for left, _ in _KINDS),
    _stereo,
)
