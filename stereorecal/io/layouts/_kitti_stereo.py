"""KITTI stereo 2012 and 2015: single rectified frames, each with a calibration file of its own."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stereorecal.io._about import about
from stereorecal.io.formats._kitti import Content, read_kitti, rectified_rig
from stereorecal.io.formats._numbers import image_size
from stereorecal.io.images._match import match_equal
from stereorecal.io.images._pairs import load_matched
from stereorecal.io.layouts._kitti_sides import Sides, sides_in
from stereorecal.io.layouts._sequences import Sequence, log_of
from stereorecal.recordings import Log

LAYOUT = "KITTI stereo 2012 or 2015 (the folder training or testing, with NNNNNN_10.png and the calibration files)"
# The benchmark's frame of each scene; "_11" is the next one.
_BENCHMARK = "_10"


@dataclass(frozen=True)
class _Kind:
    """The calibration files that belong to a pair of image folders.

    Attributes:
        folder: where they are.
        projections: the keys of the left and the right projection matrix.
        size: the key of the image size; None if the files have none.
        archive: the download that contains them.
    """

    folder: str
    projections: Sides
    size: str | None
    archive: str


_OF_2012 = "data_stereo_flow_calib.zip"
_KINDS = {  # grey before colour
    ("image_0", "image_1"): _Kind("calib", ("P0", "P1"), None, _OF_2012),
    ("colored_0", "colored_1"): _Kind("calib", ("P2", "P3"), None, _OF_2012),
    ("image_2", "image_3"): _Kind(
        "calib_cam_to_cam", ("P_rect_02", "P_rect_03"), "S_rect_02", "data_scene_flow_calib.zip"
    ),
}


def recognises(folder: Path) -> bool:
    """Whether the folder holds frames of KITTI's stereo benchmarks."""
    return any(any((folder / left).glob(f"*{_BENCHMARK}.png")) for left, _ in _KINDS)


def read(folder: Path, limit: int | None) -> Log:
    """The frames of the benchmark. Those with equal calibrations, taken on one day, are one mission, which is named
    after the number of its first frame.

    Raises:
        InputError: naming the file, if something is missing or damaged.
    """
    return log_of(folder, _sequences(folder, limit))


def _sequences(folder: Path, limit: int | None) -> Iterator[Sequence]:
    sides = sides_in(folder, list(_KINDS))
    kind = _KINDS[sides]
    days: dict[object, tuple[Path, Content, list[tuple[Path, Path]]]] = {}
    for left, right in match_equal(folder / sides[0], folder / sides[1]):
        if left.stem.endswith(_BENCHMARK):
            path = folder / kind.folder / f"{left.stem.removesuffix(_BENCHMARK)}.txt"
            content = read_kitti(path, kind.archive)
            # The projections distinguish the days; the time of the calibration does not matter.
            values = tuple(tuple(content.get(key, ())) for key in kind.projections)
            days.setdefault(values, (path, content, []))[2].append((left, right))
    for path, content, matched in days.values():
        pairs = load_matched(matched, limit)
        with about(path):
            size = image_size(content, kind.size) if kind.size else pairs[0].size
            rig = rectified_rig(content, kind.projections, size)
        yield folder / path.stem, rig, pairs
