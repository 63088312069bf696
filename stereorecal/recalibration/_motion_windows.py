"""Windows of motion: which pairs of a repair follow each other, what is tracked from one to the next, and what that
told."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.estimation import Estimate, Prior, Windows, far_enough, is_exact
from stereorecal.recalibration._case import Case, a_moment_after, soon_after
from stereorecal.recordings import LONGEST_GAP, Odometer, Pair, share_of
from stereorecal.scoring import Correspondences
from stereorecal.scoring.host import Matches, match_radius, tracked

MOST_WINDOWS = 8  # each costs a third of a second of the estimate
_LEAST_WAY = 1e-3  # metres: of any way

Windowed = tuple[tuple[int, int], ...]  # numbers of pairs that follow each other
_ODOMETER_FITS = 0.1  # of the way: drifts of the baseline are smaller


def check_motion(motion: bool | None, pairs: int, prior: Prior) -> None:
    """Refuse what cannot be asked of motion.

    Raises:
        InputError: if motion is asked for of one pair or with exact intrinsics, or is none of True, False, None.
    """
    if motion not in (None, True, False):
        raise InputError(f"motion is {motion!r}; give True (the pairs are consecutive), False, or None.")
    if motion and pairs < 2:
        raise InputError(
            "motion needs at least two consecutive pairs, in the order in which they were taken; give more, or leave "
            "motion (--motion) out."
        )
    if motion and is_exact(prior):
        raise InputError('motion determines depth, which prior="exact" takes as known; leave one of them out.')


def following(pairs: Sequence[Pair], numbers: Sequence[int], motion: bool | None, prior: Prior) -> Windowed:
    """Which of the pairs that are looked at follow each other, spread over all; none if their order is not known.

    Args:
        pairs: that are looked at.
        numbers: of them, as they were given.
        motion: whether that is the order in which they were taken; None: where their times say so.
        prior: exact intrinsics leave no depth to tell.

    Raises:
        InputError: if the pairs are of rolling shutters and do not know their times.
    """
    if motion is False or is_exact(prior):
        return ()
    if motion:
        every = [(at, at + 1) for at, number in enumerate(numbers[:-1]) if numbers[at + 1] == number + 1]
    else:
        every = [(at, after) for at in range(len(numbers)) if (after := _next(pairs, at)) is not None]
    every = [(first, second) for first, second in every if not _repeated(pairs[first], pairs[second])]
    for first, second in every:
        share_of(pairs[first], pairs[second])
    some = np.unique(np.linspace(0, len(every) - 1, min(MOST_WINDOWS, len(every))).round().astype(int))
    return tuple(every[index] for index in some)


def _repeated(first: Pair, second: Pair) -> bool:
    """Whether a recording that stutters has a pair twice: nothing has moved, whatever its times say."""
    return np.array_equal(first.left, second.left) and np.array_equal(first.right, second.right)


def _next(pairs: Sequence[Pair], at: int) -> int | None:
    """The first pair a moment later, by times that only rise in between."""
    for after in range(at + 1, len(pairs)):
        if a_moment_after(pairs[at], pairs[after]):
            return after
        if not soon_after(pairs[at].time, pairs[after].time):
            break
    return None


def windows_of(case: Case, found: Correspondences) -> dict[tuple[int, int], Any]:
    """The tracks of the windows of a case, by the numbers of their pairs. Partners of corners are looked for beside
    matches, whose rays the cameras of the case's rig give."""
    pairs, radius = case.images.pairs, match_radius(found, case.rig)
    matches = {frame: Matches.of(found, case.rig, frame) for window in case.windows for frame in window}
    tracks = {(a, b): tracked(pairs[a], pairs[b], (matches[a], matches[b]), radius) for a, b in case.windows}
    return {(a, b): replace(one, readout=share_of(pairs[a], pairs[b])) for (a, b), one in tracks.items()}


def without_frames(case: Case, tracks: dict[tuple[int, int], Any], excluded: Sequence[int]) -> Windows:
    """The windows of a case, but for those with an excluded pair."""
    used_windows = [window for window in tracks if not set(window) & set(excluded)]
    times = [[case.images.pairs[frame].time for frame in window] for window in used_windows]
    seconds = [second - first for first, second in times if first is not None and second is not None]
    if len(seconds) < len(used_windows) or min(seconds, default=1.0) <= 0.0:
        seconds = [1.0] * len(used_windows)
    used_tracks = tuple(tracks[window] for window in used_windows)
    return Windows(used_tracks, tuple(used_windows), tuple(seconds), _ways(case, used_windows))


def _ways(case: Case, used_windows: Sequence[tuple[int, int]]) -> tuple[tuple[float, float] | None, ...]:
    """How far the rig travelled in windows. An odometer errs alike in all of them, but for noise: together they say
    no more than it knows."""
    odometer = case.settings.odometer
    if odometer is None:
        return ()
    ways = _travelled(odometer, case.images.pairs, used_windows)
    metres = [None if way is None or not far_enough(way, case.rig) else way for way in ways]
    known = sum(some is not None for some in metres)
    return tuple(None if some is None else (some, odometer.deviation(some, known) + _LEAST_WAY) for some in metres)


def _travelled(odometer: Odometer, pairs: Sequence[Pair], windows: Sequence[tuple[int, int]]) -> list[float | None]:
    times = [(pairs[first].time, pairs[second].time) for first, second in windows]
    return [None if a is None or b is None else odometer.between(a, b) for a, b in times]


def check_odometer(odometer: Odometer | None, pairs: Sequence[Pair], windows: Windowed) -> None:
    """Raises:
    InputError: if an odometer knows nothing of the pairs that follow each other.
    """
    if odometer is None:
        return
    if not windows:
        raise InputError(
            "an odometer says how far the rig travelled between pairs that follow each other, and there are none; give "
            "consecutive pairs that know their times (and neither --motion off nor an exact prior)."
        )
    if all(way is None for way in _travelled(odometer, pairs, windows)):
        times = [pair.time for pair in pairs if pair.time is not None]
        pair_times = f"{min(times):g} to {max(times):g}" if times else "not known"
        raise InputError(
            f"the odometer's times are {odometer.times[0]:g} to {odometer.times[-1]:g} s, those of the pairs "
            f"{pair_times} s; give both in seconds of one clock, without gaps of more than {LONGEST_GAP:g} s."
        )


def motion_as_dict(estimated: Estimate) -> dict[str, Any]:
    """What the rig's own motion told, as plain data: how many windows, points that were followed, those that fit the
    motion of the rig, the median of its way from one pair to the next, NaN if too few could be followed, in how many
    windows it hardly moved or only turned, which tells nothing of depth, and by how much the right shutter may be late,
    None if it is not."""
    several = [one for one in estimated.motions if one.motion is not None]
    inliers, tracks = (sum(getattr(one, name) for one in several) for name in ("inliers", "tracks"))
    way = float(np.median([one.metres[0] for one in several])) if several else float("nan")
    still = sum(not one.informative for one in several)
    summary = {"windows": len(estimated.windows.tracks), "followed": tracks, "fitting": inliers, "metres": way}
    summary |= {"without_parallax": still}
    delay = estimated.delay and {
        "probability": estimated.delay.probability,
        "value": estimated.delay.seconds,
        "unit": _unit(estimated),
    }
    return summary | {"delay": delay}


def _unit(estimated: Estimate) -> str:
    """The unit of a delay: where times are not known all windows last 1, and no known times are so far apart."""
    return "pairs" if set(estimated.windows.seconds) == {1.0} else "s"


def motion_text(estimated: Estimate) -> str:
    """What the rig's own motion told, in a line."""
    summary = motion_as_dict(estimated)
    if not summary["followed"]:
        return f"{summary['windows']} windows, too few points could be followed"
    text = (
        f"{summary['windows']} windows, {summary['fitting']} of {summary['followed']} points fit the motion of the "
        f"rig, {summary['metres']:.3g} m from one pair to the next (median)"
    )
    if some := summary["without_parallax"]:
        text += f"; in {some} of them the rig only turned or stood still, which tells nothing of depth"
    if estimated.is_late:
        unit = "s" if summary["delay"]["unit"] == "s" else "of the time between pairs"
        text += f"; the right shutter is late by {summary['delay']['value']:.2g} {unit}"
    return text


def odometer_text(estimated: Estimate) -> str:
    """What came of the distances travelled that were given."""
    known = [
        (way[0], one.metres[0])
        for way, one in zip(estimated.windows.all_ways, estimated.motions, strict=True)
        if way is not None and one.motion is not None and one.informative
    ]
    if not known:
        return "not used: in no window that it knows did the rig advance far enough"
    given, moved = np.median(known, axis=0).tolist()
    fits = f"it knows {len(known)} of {len(estimated.windows.tracks)} windows"
    if abs(given - moved) <= _ODOMETER_FITS * moved:
        return fits
    return (
        f"{fits}, and does not fit: {given:.3g} m where motion shows {moved:.3g} m (median); check its unit and clock"
    )
