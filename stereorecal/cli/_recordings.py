"""The recordings that a command is about: scene folders, or images, videos and bags that lie anywhere."""

import argparse
import sys
from collections.abc import Sequence, Sized
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.cli import _calibrations, _values
from stereorecal.io import calibrated_scene, load_scene, open_pairs
from stereorecal.recalibration import MOST_FRAMES, chosen_frames
from stereorecal.recordings import Pair, Scene

_FEW = 10  # frames without partner that are named; of more, the number is said
_GIVE = (
    "give scene folders, or --left, --right and --calibration together; in place of --left and --right: --side-by-side,"
    " or --bag, --left-topic and --right-topic."
)


@dataclass(frozen=True)
class Recordings:
    """What was asked for.

    Attributes:
        scenes: each with a rig.
        absent: frames, by name or how many, that are not among their pairs, and why.
    """

    scenes: list[Scene]
    absent: tuple[tuple[str, str], ...]


def recordings(options: argparse.Namespace, *, few: bool = False) -> Recordings:
    """The scenes that were asked for; frames without partner are told on stderr.

    Args:
        few: of many frames of a scene folder, only those with the most texture are kept.

    Raises:
        InputError: if none or several kinds were asked for, or one cannot be used.
    """
    found = _scenes(options, few) if options.scenes and not _loose(options) else _recorded(options)
    for scene in found.scenes:
        if scene.rig is None:
            raise InputError(f"{scene.name}: the scene has no calibration; give one to start from.")
    if len({scene.name for scene in found.scenes}) < len(found.scenes):
        named = [replace(scene, name=path) for scene, path in zip(found.scenes, options.scenes, strict=True)]
        return replace(found, scenes=named)
    return found


def without(found: Sized, kept: Sized, why: str) -> tuple[tuple[str, str], ...]:
    """What to say of pairs that are not among those that are kept."""
    number = len(found) - len(kept)
    return ((f"{number} other {'pair' if number == 1 else 'pairs'}", why),) if number > 0 else ()


def _loose(options: argparse.Namespace) -> bool:
    named = ("left", "right", "side_by_side", "bag", "left_topic", "right_topic", "calibration")
    return any(getattr(options, name) is not None for name in named)


def _scenes(options: argparse.Namespace, few: bool) -> Recordings:
    if options.format or options.unit:
        raise InputError("--format and --unit belong to --calibration; leave them out.")
    absent: list[tuple[str, str]] = []

    def choose(pairs: Sequence, about: str) -> tuple[Pair, ...]:
        chosen, left_out = _selected(pairs, options, stream=few, about=about)
        absent.extend(left_out)
        return chosen

    every = _values.every_frame(options) and not few
    first = _values.frame_limit(options.frames) if _values.every_frame(options) else None
    found = [load_scene(Path(path), first, None if every else partial(choose, about=path)) for path in options.scenes]
    return Recordings(found, tuple(absent))


def _recorded(options: argparse.Namespace) -> Recordings:
    ways = (
        (options.left, options.right),
        (options.side_by_side,),
        (options.bag, options.left_topic, options.right_topic),
    )
    given = [way for way in ways if any(part is not None for part in way)]
    if options.scenes or len(given) != 1 or None in given[0] or options.calibration is None:
        raise InputError(_GIVE)
    topics = {"left_topic": options.left_topic, "right_topic": options.right_topic}
    place = options.left or options.side_by_side or options.bag
    absent: list[tuple[str, str]] = []

    def pairs() -> tuple[Pair, ...]:
        recorded = open_pairs(place, options.right, tolerance=options.tolerance, **topics)
        absent.extend(_told(recorded.unpaired))
        chosen, left_out = _selected(recorded.pairs, options, stream=recorded.stream, about=place)
        absent.extend(left_out)
        return chosen

    calibration = _calibrations.place(options.calibration, "--calibration")
    scene = calibrated_scene(str(place), pairs, calibration, format=options.format, unit=options.unit)
    return Recordings([scene], tuple(absent))


def _selected(
    pairs: Sequence,  # of Pair; said so, a checker of types would read one to look at it
    options: argparse.Namespace,
    *,
    stream: bool,
    about: str,
) -> tuple[tuple[Pair, ...], tuple[tuple[str, str], ...]]:
    """The pairs that --from, --to, --every, --frames and --limit leave, read; and what to say of the others."""
    wanted = pairs[_values.stretch(options)][: _values.frame_limit(options.frames)]
    if not len(wanted):
        raise InputError(f"{about}: of {len(pairs)} pairs, --from, --to and --every leave none; change them.")
    limit = _values.limit(options.limit, MOST_FRAMES if stream else None)
    chosen = tuple(wanted) if limit is None else chosen_frames(wanted, limit)
    return chosen, (
        *without(pairs, wanted, "outside of --from, --to, --every and --frames"),
        *without(wanted, chosen, f"of {limit} stretches of equal length, the pair with the most texture is used"),
    )


def _told(unpaired: Sequence[str]) -> list[tuple[str, str]]:
    """What to say of frames without partner; also on stderr."""
    if not unpaired:
        return []
    why = "no partner in the other camera"
    number = len(unpaired)
    frames = "1 frame has" if number == 1 else f"{number} frames have"
    few = ", ".join(unpaired[:3]) + (", …" if number > 3 else "")
    print(
        f"stereorecal: {frames} no partner in the other camera and {'is' if number == 1 else 'are'} left out: {few}",
        file=sys.stderr,
    )
    more = [(f"{number - _FEW} more frames", why)] if number > _FEW else []
    return [(name, why) for name in unpaired[:_FEW]] + more
