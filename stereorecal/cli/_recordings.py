"""What a command reads: scene folders, images, videos and bags from anywhere, or cameras that run."""

from collections.abc import Callable, Iterable, Sequence, Sized
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.cli._options import value_of
from stereorecal.cli._repair_commands import MonitorOptions, RecalibrateOptions, ScoreOptions
from stereorecal.cli._shared_options import RecordingOptions, folders_of
from stereorecal.cli._streams import say
from stereorecal.geometry import StereoRig, same_rig
from stereorecal.io import about, bag_scene, calibrated_scene, camera_pairs, load_rig, load_scene, open_pairs
from stereorecal.recalibration import MOST_FRAMES, chosen_frames, fixed
from stereorecal.recordings import Images, LazyPairs, Pair, PairSequence, Scene
from stereorecal.report.number_text import short_list

_LONG = 100  # pairs; of a longer recording not all are looked at, as of a video
_BY_ORDER = "in order, since no name on the left has a partner on the right"
_DARK = 100  # pairs that cannot be used, at most, before the first that can: a camera that is switched on
_OTHERS = ("left", "right", "side_by_side", "bag", "limit")

_Choose = Callable[..., tuple[Pair, ...]]  # of pairs that are not read yet, a stream or not, and what to call them


@dataclass
class Recordings:
    """The recordings of a command.

    Attributes:
        scenes: each with a rig.
        absent: (frames, reason): frames that are in no pair, by name or number, and why.
        pairing: how images were paired, if not by their names or times.
    """

    scenes: list[Scene] = field(default_factory=list)
    absent: list[tuple[str, str]] = field(default_factory=list)
    pairing: str | None = None

    def leave_out(self, found: Sized, used: Sized, why: str) -> None:
        """Note the pairs that are not used."""
        number = len(found) - len(used)
        if number > 0:
            self.absent.append((f"{number} other {'pair' if number == 1 else 'pairs'}", why))


def recordings(options: RecalibrateOptions | ScoreOptions, *, few: bool = False) -> Recordings:
    """The scenes of the command line; frames without partner are named on stderr. `few`: of many frames keep only those
    with the most texture."""
    found = Recordings()

    def choose(pairs: LazyPairs, *, stream: bool = False, about: str) -> tuple[Pair, ...]:
        wanted = _wanted(pairs, options, about)
        limit = value_of(options, "limit", MOST_FRAMES if few or stream or len(wanted) > _LONG else None)
        chosen = tuple(wanted) if limit is None else chosen_frames(wanted, limit)
        found.leave_out(pairs, wanted, "outside of --pairs")
        why = f"of {limit} stretches of equal length, the pair with the most texture is used"
        found.leave_out(wanted, chosen, why)
        return chosen

    _read(options, choose, found)
    if options.fix is not None:
        found.scenes = [_fixed(scene, options.fix) for scene in found.scenes]
    return found


def rig_of(scene: Scene) -> StereoRig:
    """The calibration of a scene of the command line; one that has none was refused."""
    assert scene.rig is not None
    return scene.rig


def _fixed(scene: Scene, cause: str) -> Scene:
    with about(scene.name):
        rig, pairs = fixed(rig_of(scene), scene.pairs, cause)
    ratio = float(rig.left.focal[0] / rig_of(scene).left.focal[0])
    done = {
        "scaled": f"K scaled by {ratio:.3g}",
        "exchanged": "left and right exchanged",
        "turned": "both images turned by 180 degrees",
        "late": "right images paired one frame earlier",
        "early": "right images paired one frame later",
    }
    say(f"{scene.name}: {done[cause]} (--fix {cause})")
    return replace(scene, rig=rig, pairs=pairs)


def watched(options: MonitorOptions) -> tuple[Scene, PairSequence]:
    """The one scene of the command line, with its first pair only; and all its pairs, which are read one by one."""
    every: list[PairSequence] = []

    def first(pairs: LazyPairs, *, stream: bool = False, about: str) -> tuple[Pair, ...]:
        wanted, limit = _wanted(pairs, options, about), value_of(options, "limit")
        every.append(wanted if limit is None else chosen_frames(wanted, limit))
        return tuple(every[-1][:1])

    found = Recordings()
    _read(options, first, found)
    if len(found.scenes) != 1:
        raise InputError("one rig is watched at a time; give one scene.")
    if len(every) != 1:
        raise InputError("folders are watched one after the other; give one, and the next with the same --state.")
    return found.scenes[0], every[0]


def _read(options: RecordingOptions, choose: _Choose, found: Recordings) -> None:
    """Add the recordings of the command line, with the pairs that are chosen."""
    how = {"format": options.format, "unit": options.unit, "cameras": value_of(options, "cameras")}
    for name in options.scenes:
        found.scenes.append(_joined(name, [_scene(folder, options, choose, how) for folder in folders_of(name)]))
    if not options.scenes:
        found.scenes.append(_scene_of_images(options, choose, how, found))
    for scene in found.scenes:
        if scene.rig is None:
            raise InputError(f"{scene.name}: the scene has no calibration; give one with --calibration.")
    if len({scene.name for scene in found.scenes}) < len(found.scenes):
        found.scenes = [replace(one, name=path) for one, path in zip(found.scenes, options.scenes, strict=True)]


def _scene(folder: str, options: RecordingOptions, choose: _Choose, how: dict[str, Any]) -> Scene:
    """The scene of a folder, with the calibration of --calibration, if there is one."""
    scene = load_scene(Path(folder), choose=partial(choose, about=folder))
    if options.calibration is None:
        return scene
    return replace(scene, rig=load_rig(value_of(options, "calibration"), size=scene.pairs[0].as_taken().size, **how))


def _joined(name: str, parts: Sequence[Scene]) -> Scene:
    """One scene of all folders of a recording, which have one calibration."""
    first = parts[0]
    if len(parts) == 1:
        return first
    for one in parts[1:]:
        if one.rig is None or first.rig is None or not same_rig(one.rig, first.rig):
            raise InputError(f"{one.name} has another calibration than {first.name}; repair them as two recordings.")
    pairs = tuple(pair.named(f"{one.name}/{pair.name}") for one in parts for pair in one.pairs)
    return replace(first, name=name, pairs=pairs)


def _scene_of_images(options: RecordingOptions, choose: _Choose, how: dict[str, Any], found: Recordings) -> Scene:
    place = next(one for one in (options.bag, options.left, options.side_by_side) if one is not None)
    right = None if options.bag else options.right
    topics = {"left_topic": options.left, "right_topic": options.right} if options.bag else {}

    def pairs(sizes: tuple[tuple[int, int], tuple[int, int]] | None) -> tuple[Pair, ...]:
        recorded = open_pairs(place, right, tolerance=options.tolerance, sizes=sizes, **topics)
        if recorded.unpaired:
            found.absent.append((short_list(recorded.unpaired), "no partner in the other camera"))
            say(f"left out, without partner in the other camera: {short_list(recorded.unpaired)}")
        found.pairing = _BY_ORDER if recorded.by_order else None
        return choose(recorded.pairs, stream=recorded.stream, about=place)

    if options.calibration is not None:
        return calibrated_scene(str(place), pairs, value_of(options, "calibration"), **how)
    assert options.left is not None
    assert options.right is not None
    return bag_scene(place, (options.left, options.right), pairs, unit=options.unit)


def _wanted(pairs: LazyPairs, options: RecordingOptions, about: str) -> LazyPairs:
    """The pairs that --pairs selects, not read yet."""
    wanted = pairs[options.stretch()]
    if not len(wanted):
        raise InputError(f"{about}: of {len(pairs)} pairs, --pairs {options.pairs} leaves none; change it.")
    return wanted


def watched_cameras(options: MonitorOptions) -> tuple[Scene, Iterable[Pair | Images]]:
    """A scene of the calibration and the first pair of the cameras; and all their pairs, as they come."""
    if options.scenes or any(getattr(options, name) is not None for name in _OTHERS):
        raise InputError("--camera takes the place of a recording, and of --limit; leave the others out.")
    if options.calibration is None:
        raise InputError("--camera needs --calibration, the file of the rig.")
    if options.tolerance is not None and not options.tolerance >= 0.0:
        raise InputError(f"--tolerance is {options.tolerance}; give seconds, such as 0.005.")
    names, wanted = value_of(options, "camera"), options.stretch()
    coming, name = camera_pairs(names, options.tolerance), f"camera {' and '.join(names)}"
    before: list[Pair | Images] = []

    def first(_: object) -> tuple[Pair, ...]:
        for pair in islice(coming, _DARK):
            before.append(pair)
            if isinstance(pair, Pair):
                return (pair,)
        raise InputError(f"{name}: of {len(before)} pairs none can be used; check the cameras.")

    how = {"format": options.format, "unit": options.unit, "cameras": value_of(options, "cameras")}
    scene = calibrated_scene(name, first, value_of(options, "calibration"), **how)
    if scene.rig is None:
        raise InputError("--calibration: the file holds no calibration; give another.")
    return scene, islice(chain(before, coming), wanted.start, wanted.stop, wanted.step)
