"""What comes before a search: images and options checked, which frames count and follow each other, what is known."""

from stereorecal.estimation import is_exact
from stereorecal.geometry import StereoRig
from stereorecal.objectives import Parameters
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._frame_choice import selected_frames
from stereorecal.recalibration._match_ranges import resolved_ranges
from stereorecal.recalibration._motion_windows import check_motion, check_odometer, following
from stereorecal.recalibration._prior_use import prior_for_health, prior_of, prior_use
from stereorecal.recalibration._schedule import ScoreKind, check_schedule
from stereorecal.recalibration._settings import Settings
from stereorecal.recordings import Pairs
from stereorecal.scoring import pyramid


def what_may_change(rig: StereoRig, settings: Settings) -> Parameters:
    """The parameters that may change in the end: those that are named; by default every one of the rig, or, where the
    intrinsics are exact or only the count is asked, the extrinsics."""
    rows = settings.schedule.stages[-1].score is ScoreKind.EPIPOLAR
    return settings.free.of_all(rig, intrinsics=rows and not is_exact(settings.prior))


def prepared(rig: StereoRig, pairs: Pairs, settings: Settings, *, learns: bool = True) -> Case:
    """The case of a repair, of whose strategies the extrinsics are asked.

    Args:
        learns: whether a prior is to follow: pairs that a saved one rests on do not count again then.

    Raises:
        InputError: as `recalibrate`.
    """
    images, free = pyramid(rig, pairs, settings.view), settings.free
    free.check(rig)
    ranges = resolved_ranges(settings.ranges, [("", images.pairs)])
    check_schedule(settings.schedule, free)
    check_motion(settings.motion, len(images.pairs), settings.prior)
    use = prior_use(settings.prior, rig, images.pairs) if learns else None
    numbers = tuple(range(len(images.pairs))) if use is None else use.numbers
    if free.shared:
        chosen = selected_frames([images.pairs[number] for number in numbers], ranges)
        numbers = tuple(numbers[number] for number in chosen)
    if len(numbers) < len(images.pairs):
        images = pyramid(rig, [images.pairs[number] for number in numbers], images.view)
    measured = bool(ranges) or settings.odometer is not None
    prior = prior_for_health(settings.prior, rig) if use is None else use.prior
    known = prior_of(prior, free, rig, settings.reach, ranges=measured)
    windows = following(images.pairs, numbers, settings.motion, known)
    check_odometer(settings.odometer, images.pairs, windows)
    return Case(
        images=images,
        matcher=settings.matcher,
        reach=settings.reach,
        free=free.extrinsics,
        prior=known,
        ranges=ranges,
        windows=windows,
        tolerances=settings.tolerances,
        odometer=settings.odometer,
        prior_use=use,
        selected=numbers if free.shared or (use is not None and use.dropped) else None,
    )
