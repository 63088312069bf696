"""What a command reads: scene folders, images, videos and bags from anywhere, or cameras that run."""

from collections.abc import Callable, Iterable, Sequence, Sized
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.cli._options import value_of
from stereorecal.cli._repair_commands import MonitorOptions, RecalibrateOptions, ScoreOptions
from stereorecal.cli._shared_options import RecordingOptions, folders_of
from stereorecal.cli._streams import say
from stereorecal.geometry import same_rig
from stereorecal.io import about, bag_scene, calibrated_scene, camera_pairs, load_rig, load_scene, open_pairs
from stereorecal.recalibration import MOST_FRAMES, chosen_frames, fixed
from stereorecal.recordings import Images, LazyPairs, Pair, PairSequence, Scene

_LONG = 100  # pairs; of a longer recording not all are looked at, as of a video
_FEW = 10  # frames without partner that are named; of more, their number is stated
_BY_ORDER = "in order, since no name on the left has a partner on the right"

_Select = Callable[..., tuple[tuple[Pair, ...], tuple[tuple[str, str], ...]]]  # as `_selected`

_DARK = 100  # pairs that cannot be used, at most, before the first that can: a camera that is switched on
_OTHERS = ("left", "right", "side_by_side", "bag", "limit")


@dataclass(frozen=True)
class Recordings:
    """The recordings of a command.

    Attributes:
        scenes: each with a rig.
        absent: (frames, reason): frames that are in no pair, by name or number, and why.
        pairing: how images were paired, if not by their names or times.
    """

    scenes: list[Scene]
    absent: tuple[tuple[str, str], ...]
    pairing: str | None = None


def recordings(options: RecalibrateOptions | ScoreOptions, *, few: bool = False) -> Recordings:
    """The scenes of the command line; frames without partner are named on stderr. `few`: of many frames keep only those
    with the most texture."""
    found = _recordings(options, partial(_selected, few=few))
    if options.fix is not None:
        (scene,) = found.scenes
        found = replace(found, scenes=[_fixed(scene, options.fix)])
    return found


def _fixed(scene: Scene, cause: str) -> Scene:
    assert scene.rig is not None
    with about(scene.name):
        rig, pairs = fixed(scene.rig, scene.pairs, cause)
    ratio = float(rig.left.focal[0] / scene.rig.left.focal[0])
    done = f"K scaled by {ratio:.3g}" if cause == "scaled" else "left and right exchanged"
    done = "both images turned by 180 degrees" if cause == "turned" else done
    if cause in ("late", "early"):
        done = f"right images paired one frame {'earlier' if cause == 'late' else 'later'}"
    say(f"{scene.name}: {done} (--fix {cause})")
    return replace(scene, rig=rig, pairs=pairs)


def watched(options: MonitorOptions) -> tuple[Scene, PairSequence]:
    """The one scene of the command line, with its first pair only; and all its pairs, which are read one by one."""
    every: list[PairSequence] = []

    def first(pairs: LazyPairs, options: RecordingOptions, *, stream: bool, about: str):
        if options.limit in (None, "all"):
            every.append(_wanted(pairs, options, about))
        else:
            every.append(_selected(pairs, options, stream=stream, about=about)[0])
        return tuple(every[-1][:1]), ()

    scenes = _recordings(options, first).scenes
    if len(scenes) != 1:
        raise InputError("one rig is watched at a time; give one scene.")
    if len(every) != 1:
        raise InputError("folders are watched one after the other; give one, and the next with the same --state.")
    return scenes[0], every[0]


def _recordings(options: RecordingOptions, select: _Select) -> Recordings:
    found = _scenes(options, select) if options.scenes else _images_elsewhere(options, select)
    for scene in found.scenes:
        if scene.rig is None:
            raise InputError(f"{scene.name}: the scene has no calibration; give one with --calibration.")
    if len({scene.name for scene in found.scenes}) < len(found.scenes):
        named = [replace(scene, name=path) for scene, path in zip(found.scenes, options.scenes, strict=True)]
        return replace(found, scenes=named)
    return found


def left_out_pairs(found: Sized, used: Sized, why: str) -> tuple[tuple[str, str], ...]:
    """(frames, reason) of the pairs that are left out."""
    number = len(found) - len(used)
    return ((f"{number} other {'pair' if number == 1 else 'pairs'}", why),) if number > 0 else ()


def _scenes(options: RecordingOptions, select: _Select) -> Recordings:
    if options.calibration is None and (options.format or options.cameras or options.unit):
        raise InputError("--format, --unit and --cameras belong to --calibration; leave them out.")
    if options.tolerance is not None:
        raise InputError(
            "--tolerance belongs to --left and --right, or --bag; a scene folder pairs by names: leave it out."
        )
    absent: list[tuple[str, str]] = []

    def chosen(pairs: LazyPairs, path: str) -> tuple[Pair, ...]:
        found, left_out = select(pairs, options, stream=False, about=path)
        absent.extend(left_out)
        return found

    found = []
    for scene in options.scenes:
        parts = [load_scene(Path(path), choose=partial(chosen, path=path)) for path in folders_of(scene)]
        found.append(_as_one(scene, [_with_calibration(part, options) for part in parts]))
    return Recordings(found, tuple(absent))


def _with_calibration(scene: Scene, options: RecordingOptions) -> Scene:
    """The scene with the calibration of --calibration, if there is one."""
    if options.calibration is None:
        return scene
    return replace(
        scene, rig=load_rig(value_of(options, "calibration"), size=scene.pairs[0].size, **_how_read(options))
    )


def _how_read(options: RecordingOptions) -> dict[str, Any]:
    """How a calibration is read, as `load_rig` takes it."""
    return {"format": options.format, "unit": options.unit, "cameras": value_of(options, "cameras")}


def _as_one(name: str, parts: Sequence[Scene]) -> Scene:
    """One scene of all folders of a recording."""
    first = parts[0]
    if len(parts) == 1:
        return first
    for one in parts[1:]:
        if one.rig is None or first.rig is None or not same_rig(one.rig, first.rig):
            raise InputError(f"{one.name} has another calibration than {first.name}; repair them as two recordings.")
    pairs = tuple(pair.named(f"{one.name}/{pair.name}") for one in parts for pair in one.pairs)
    return replace(first, name=name, pairs=pairs)


def _images_elsewhere(options: RecordingOptions, select: _Select) -> Recordings:
    place = next(one for one in (options.bag, options.left, options.side_by_side) if one is not None)
    right = None if options.bag else options.right
    topics = {"left_topic": options.left, "right_topic": options.right} if options.bag else {}
    absent: list[tuple[str, str]] = []
    pairing: list[str] = []

    def pairs(sizes: tuple[tuple[int, int], tuple[int, int]] | None) -> tuple[Pair, ...]:
        recorded = open_pairs(place, right, tolerance=options.tolerance, sizes=sizes, **topics)
        absent.extend(_unpaired_frames(recorded.unpaired))
        pairing.extend([_BY_ORDER] * recorded.by_order)
        chosen, left_out = select(recorded.pairs, options, stream=recorded.stream, about=place)
        absent.extend(left_out)
        return chosen

    if options.calibration is None:
        assert options.left is not None
        assert options.right is not None
        if options.format or options.cameras:
            raise InputError("--format and --cameras belong to --calibration; leave them out.")
        scene = bag_scene(place, (options.left, options.right), pairs, unit=options.unit)
        return Recordings([scene], tuple(absent), *pairing)
    scene = calibrated_scene(str(place), pairs, value_of(options, "calibration"), **_how_read(options))
    return Recordings([scene], tuple(absent), *pairing)


def _selected(
    pairs: LazyPairs, options: RecordingOptions, *, stream: bool, about: str, few: bool = False
) -> tuple[tuple[Pair, ...], tuple[tuple[str, str], ...]]:
    """The pairs that --pairs and --limit select, read; and (frames, reason) of the others."""
    wanted = _wanted(pairs, options, about)
    limit = value_of(options, "limit", MOST_FRAMES if few or stream or len(wanted) > _LONG else None)
    chosen = tuple(wanted) if limit is None else chosen_frames(wanted, limit)
    return chosen, (
        *left_out_pairs(pairs, wanted, "outside of --pairs"),
        *left_out_pairs(
            wanted, chosen, f"of {limit} stretches of equal length, the pair with the most texture is used"
        ),
    )


def _wanted(pairs: LazyPairs, options: RecordingOptions, about: str) -> LazyPairs:
    """The pairs that --pairs selects, not read yet."""
    wanted = pairs[options.stretch()]
    if not len(wanted):
        raise InputError(f"{about}: of {len(pairs)} pairs, --pairs {options.pairs} leaves none; change it.")
    return wanted


def _unpaired_frames(unpaired: Sequence[str]) -> list[tuple[str, str]]:
    """(frames, reason) of the frames without partner, which are also named on stderr."""
    if not unpaired:
        return []
    why = "no partner in the other camera"
    number = len(unpaired)
    frames = "1 frame has" if number == 1 else f"{number} frames have"
    few = ", ".join(unpaired[:3]) + (", …" if number > 3 else "")
    say(f"{frames} no partner in the other camera and {'is' if number == 1 else 'are'} left out: {few}")
    more = [(f"{number - _FEW} more frames", why)] if number > _FEW else []
    return [(name, why) for name in unpaired[:_FEW]] + more


def watched_cameras(options: MonitorOptions) -> tuple[Scene, Iterable[Pair | Images]]:
    """A scene of the calibration and the first pair of the cameras; and all their pairs, as they come."""
    if options.scenes or any(getattr(options, name) is not None for name in _OTHERS):
        raise InputError("--camera takes the place of a recording, and of --limit; leave the others out.")
    if options.calibration is None:
        raise InputError("--camera needs --calibration, the file of the rig.")
    if options.tolerance is not None and not options.tolerance >= 0.0:
        raise InputError(f"--tolerance is {options.tolerance}; give seconds, such as 0.005.")
    names = value_of(options, "camera")
    wanted = options.stretch()
    coming = camera_pairs(names, options.tolerance)
    before: list[Pair | Images] = []

    def first(_: object) -> tuple[Pair, ...]:
        for pair in islice(coming, _DARK):
            before.append(pair)
            if isinstance(pair, Pair):
                return (pair,)
        raise InputError(f"camera {' and '.join(names)}: of {len(before)} pairs none can be used; check the cameras.")

    name, calibration = f"camera {' and '.join(names)}", value_of(options, "calibration")
    scene = calibrated_scene(name, first, calibration, **_how_read(options))
    if scene.rig is None:
        raise InputError("--calibration: the file holds no calibration; give another.")
    return scene, islice(chain(before, coming), wanted.start, wanted.stop, wanted.step)
