"""Image pairs of a recording (files, side-by-side images, videos, bags), read one by one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import InputError, PairingWarning, warn
from stereorecal.io._read_files import AnyPath, about
from stereorecal.io.images._bags import bag_folder, bag_sources, is_bag
from stereorecal.io.images._frame_source import FrameSource, counts_per_second, halves, has_time, pairs_by_time, time_of
from stereorecal.io.images._image_files import read_image
from stereorecal.io.images._load_pairs import Sizes, check_limit, find_images, fitted_pair, load_matched
from stereorecal.io.images._match_by_name import find_partners
from stereorecal.io.images._videos import is_video, video_source
from stereorecal.recordings import LazyPairs, Pair

_FEW = 3  # names that a message mentions


@dataclass(frozen=True, eq=False)
class Recorded:
    """The result of `open_pairs`.

    Attributes:
        pairs: all of them, read when used: take a slice, or pass them to a function that reads one after the other;
            `tuple(recorded.pairs)` reads all.
        unpaired: names of frames that have no partner.
        stream: whether they are frames of a video or a bag, which are many and show the same again and again.
        by_order: whether images were matched by their order, since neither names nor times corresponded.
    """

    pairs: LazyPairs
    unpaired: tuple[str, ...]
    stream: bool
    by_order: bool = False


def open_pairs(
    left: AnyPath,
    right: AnyPath | None = None,
    *,
    left_topic: str | None = None,
    right_topic: str | None = None,
    tolerance: float | None = None,
    sizes: Sizes | None = None,
) -> Recorded:
    """The pairs of a recording, without reading them yet.

    Args:
        left: left images (a file, a folder or a pattern) or a video; without `right` side-by-side images or a video
            of them; with topics a ROS bag: a file of ROS 1, or a folder of ROS 2 or its metadata.yaml.
        right: the right images or the right video.
        left_topic, right_topic: of the bag: images, raw or compressed.
        tolerance: the largest difference of times [s] within a pair; default a quarter of the time between left frames.
            Files are matched by their names, as `load_pairs` says; with a tolerance by the times that are their
            names, in seconds, or in nanoseconds if they have 16 digits and more (in microseconds, if frames would
            else lie closer than a millisecond); without one, too, if names have times since 1970 (seconds with a
            fraction, or nanoseconds) and hardly any name is on both sides.
        sizes: (width, height) of the left and of the right camera, if they differ: images of these are resampled to
            the smaller size.

    Raises:
        InputError: if nothing is found, a file or video cannot be read, no frame or, by names, hardly one has a
            partner, or there is nothing for a tolerance to hold for.

    Warns:
        PairingWarning: if files were matched by their order.
        CalibrationWarning: as `load_pair`.
    """
    topics = None if left_topic is None or right_topic is None else (left_topic, right_topic)
    if (left_topic, right_topic) != (None, None) and (topics is None or right is not None):
        raise InputError("a bag takes both a left and a right topic, and no right images.")
    if tolerance is not None and topics is None and right is None:
        raise InputError(
            f"{left}: left and right come from one image, so there are no times to match; leave the tolerance out."
        )
    place = bag_folder(Path(left)).absolute()
    return _opened(place, None if right is None else Path(right).absolute(), topics, tolerance, sizes)


def load_pairs(
    left: AnyPath, right: AnyPath, limit: int | None = None, *, sizes: Sizes | None = None
) -> tuple[Pair, ...]:
    """The pairs that `open_pairs` finds in left and right images, each a glob pattern, a folder or one file.

    Files whose names are equal, or equal but for what all names of a side have in common (cam1_0007 and cam2_0007, A7
    and B7) or for left/right, L/R or 0/1, belong together. Those that one camera lost are left out, as long as at
    least half have a partner. If no name has one, files are matched in natural order (9 before 10).

    Args:
        limit: read only the first `limit` pairs.
        sizes: (width, height) of the left and of the right camera, if they differ: images of these are resampled to
            the smaller size.

    Raises:
        InputError: if nothing matches, most images have no partner, or a file is bad (see `load_pair`).

    Warns:
        PairingWarning: if images were left out, or files matched by their order.
        CalibrationWarning: as `load_pair`.
    """
    check_limit(limit)
    found = open_pairs(left, right, sizes=sizes)
    if found.unpaired:
        number, few = len(found.unpaired), ", ".join(found.unpaired[:_FEW])
        warn(
            f"{number} of {number + 2 * len(found.pairs)} images have no partner in the other camera and are left "
            f"out: {few}{', …' if number > _FEW else ''}.",
            PairingWarning,
        )
    return tuple(found.pairs[:limit])


def _opened(
    left: Path, right: Path | None, topics: tuple[str, str] | None, tolerance: float | None, sizes: Sizes | None
) -> Recorded:
    """The result of `open_pairs`, of what a worker can be told."""
    told = (left, right, topics, tolerance, sizes)
    if topics is not None:
        sources = bag_sources(left, topics)
    elif is_bag(left):
        raise InputError(f"{left}: this is a bag; say which topics are the left and the right images.")
    elif right is None:
        if is_video(left):
            source = video_source(left)
        else:
            files = find_images(left)
            names = tuple(file.name for file in files)
            source = FrameSource(str(left), names, None, lambda index: read_image(str(files[index]))[0])
        return _paired_frames(told, *halves(source), [(i, i) for i in range(len(source.names))], is_video(left))
    elif is_video(left) != is_video(right):
        raise InputError(f"{left} and {right}: one is a video and the other is not; give two of a kind.")
    elif is_video(left):
        sources = video_source(left), video_source(right)
    else:
        files = find_images(left), find_images(right)
        if tolerance is not None or _times_alone_tell(*files):
            return _files_by_time((left, right), files, tolerance, sizes)
        found = find_partners(*files)
        alone = tuple("/".join(path.parts[-2:]) for path in found.unmatched)  # with the folder, which tells whose it is
        return Recorded(load_matched(found.matched, sizes=sizes), alone, False, found.by_order)
    first, second = sources
    with about(f"{first.where} and {second.where}"):
        found = pairs_by_time(np.asarray(first.times), np.asarray(second.times), tolerance)
    return _paired_frames(told, *sources, found, stream=True)


def _paired_frames(
    told: tuple[Any, ...], left: FrameSource, right: FrameSource, found: list[tuple[int, int]], stream: bool
) -> Recorded:
    """Frames as pairs, by the numbers of the left and the right ones that belong together."""
    times = [None if left.times is None else float(left.times[first]) for first, _ in found]

    def read(number: int) -> Pair:
        first, second = found[number]
        name = left.names[first]
        about = name if left.names is right.names else f"{name} and {right.names[second]}"
        shots, origin = ((left.read(first), 1), (right.read(second), 1)), (_read_in_worker, (told, number))
        return fitted_pair(shots, told[-1], about, name, origin=origin, time=times[number])

    frames = [_Frame(told, number, read) for number in range(len(found))]
    pairs = LazyPairs(frames, [left.names[first] for first, _ in found], times)
    return Recorded(pairs, _alone(left.names, right.names, found), stream)


def _files_by_time(
    places: tuple[Path, Path], files: tuple[list[Path], list[Path]], tolerance: float | None, sizes: Sizes | None
) -> Recorded:
    per_second = counts_per_second([file.stem for file in files[0]]) or 1e9

    def time(file: Path) -> float:
        with about(file.parent):
            return time_of(file.stem, per_second)

    left, right = (sorted(side, key=time) for side in files)
    with about(" and ".join(map(str, places))):
        found = pairs_by_time(np.array([*map(time, left)]), np.array([*map(time, right)]), tolerance)
    matched = [(left[one], right[other]) for one, other in found]
    pairs = load_matched(matched, times=[time(path) for path, _ in matched], sizes=sizes)
    return Recorded(pairs, _alone([path.name for path in left], [path.name for path in right], found), False)


def _alone(left: Sequence[str], right: Sequence[str], found: list[tuple[int, int]]) -> tuple[str, ...]:
    """The names of frames without partner."""
    sides = ((left, {first for first, _ in found}), (right, {second for _, second in found}))
    return tuple(name for names, paired in sides for index, name in enumerate(names) if index not in paired)


_opened_once = lru_cache(maxsize=2)(_opened)


def _read_in_worker(told: tuple[Any, ...], number: int) -> Pair:
    """A pair in another process, which is handed pair after pair and opens their video once."""
    return _opened_once(*told).pairs[number]


class _Frame:
    """A function that reads a pair from what is open here; in another process it opens that again."""

    def __init__(self, told: tuple[Any, ...], number: int, read: Callable[[int], Pair]):
        self._told, self._number, self._read = told, number, read

    def __call__(self) -> Pair:
        return self._read(self._number)

    def __reduce__(self):
        return partial, (_read_in_worker, self._told, self._number)


def _times_alone_tell(left: list[Path], right: list[Path]) -> bool:
    """Whether all names are times since 1970, and hardly one is on both sides: clocks differ a little."""
    names, others = ([file.stem for file in side] for side in (left, right))
    fewest = min(len(names), len(others))
    return fewest > 1 and all(map(has_time, names + others)) and 2 * len({*names} & {*others}) < fewest
