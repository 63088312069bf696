"""KITTI stereo 2012 and 2015: single rectified frames, each with a calibration file of its own."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._read_rig import read_files
from stereorecal.io.formats.text._document import Syntax, read_document
from stereorecal.io.images._load_pairs import load_matched
from stereorecal.io.images._match_by_name import match_equal
from stereorecal.io.layouts._layout import Sequence, Sides, log_of, sides_in
from stereorecal.recordings import Log

LAYOUT = "KITTI stereo 2012 or 2015 (the folder training or testing, with NNNNNN_10.png and the calibration files)"
# The benchmark's frame of each scene; "_11" is the next one.
_BENCHMARK = "_10"


@dataclass(frozen=True)
class _Kind:
    """The calibration files that belong to a pair of image folders.

    Attributes:
        folder: where they are.
        format: of these files.
        cameras: their names in there.
        projections: the keys of the left and the right projection matrix.
        archive: the download that contains them.
    """

    folder: str
    format: str
    cameras: Sides
    projections: Sides
    archive: str


_OF_2012 = "data_stereo_flow_calib.zip"
_KINDS = {  # grey before colour
    ("image_0", "image_1"): _Kind("calib", "kitti-odometry", ("P0", "P1"), ("P0", "P1"), _OF_2012),
    ("colored_0", "colored_1"): _Kind("calib", "kitti-odometry", ("P2", "P3"), ("P2", "P3"), _OF_2012),
    ("image_2", "image_3"): _Kind(
        "calib_cam_to_cam", "kitti-raw", ("02", "03"), ("P_rect_02", "P_rect_03"), "data_scene_flow_calib.zip"
    ),
}


def recognises(folder: Path) -> bool:
    """Whether the folder holds frames of KITTI's stereo benchmarks."""
    return any(any((folder / left).glob(f"*{_BENCHMARK}.png")) for left, _ in _KINDS)


def read(folder: Path, limit: int | None) -> Log:
    """The frames of the benchmark. Those with equal calibrations, taken on one day, are one mission, which is named
    after the number of its first frame."""
    return log_of(folder, _sequences(folder, limit))


def _sequences(folder: Path, limit: int | None) -> Iterator[Sequence]:
    sides = sides_in(folder, _KINDS)
    kind = _KINDS[sides]
    missing = f"download {kind.archive} from KITTI's page and unpack it over the images."
    days: dict[object, tuple[Path, list[tuple[Path, Path]]]] = {}
    for left, right in match_equal(folder / sides[0], folder / sides[1]):
        if left.stem.endswith(_BENCHMARK):
            path = folder / kind.folder / f"{left.stem.removesuffix(_BENCHMARK)}.txt"
            content = read_document(path, Syntax.COLONS, missing).content
            # The projections distinguish the days; the time of the calibration does not matter.
            values = tuple(tuple(content.get(key, ())) for key in kind.projections)
            days.setdefault(values, (path, []))[1].append((left, right))
    for path, matched in days.values():
        pairs = load_matched(matched, limit)
        hints = Hints(size=pairs[0].size, cameras=kind.cameras, rectified=True)
        yield folder / path.stem, read_files([path], kind.format, hints=hints, if_missing=missing), pairs
