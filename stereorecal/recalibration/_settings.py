"""The settings of a repair: what callers say by name, what a repair computes with, and how people read it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from difflib import get_close_matches
from typing import Any, TypedDict

from stereorecal._errors import InputError
from stereorecal.decision import Tolerances, as_tolerances
from stereorecal.estimation import Prior, check_prior
from stereorecal.geometry import AnyView, checked_view_arguments
from stereorecal.matching import AbstractMatcher, as_matcher, name_of
from stereorecal.objectives import Parameters, Reach, as_parameters, as_reach
from stereorecal.recalibration._expected import Distance, as_distances
from stereorecal.recalibration._match_ranges import as_ranges, with_ranges
from stereorecal.recalibration._schedule import LOOK, Schedule, as_schedule
from stereorecal.recordings import Odometer, Range
from stereorecal.strategies import Budget, as_budget, origin_of


class HealthOptions(TypedDict, total=False):
    """Options of `health`, all of which `recalibrate` takes as well; each is given by name.

    Attributes:
        matcher: a matcher, or the name of an installed one (default "sad"); without `num_disparities` the range is
            measured, and again as the rig comes right.
        view: default `sr.view(rig)`; also the arguments of `sr.view` by name, such as {"field": 140}.
        prior: how well the initial calibration was known before it drifted: "saved", as it was saved with it (also for
            None, if it was), or the prior of an earlier solution, for which pairs that it rests on do not count again;
            "default" (also for None), as a chessboard calibration of this rig; standard deviations by name, or an
            `sr.CalibrationCovariance`; or "exact": its intrinsics are the truth, and all that rows show is a drift.
        motion: whether the rig's own motion between consecutive pairs is used, which tells depth: True takes the pairs
            as they were taken, one after the other, the rig advancing by a fraction of a baseline or more in between;
            None uses it where pairs know their times, at most half a second apart; False never.
        tolerances: what is asked of a change, and the distances at which it is judged: a `Tolerances`, or some of its
            values by name, such as {"distances": (3, 8), "harm": 0.001}.
        distances: at which errors of depth are reported, such as ("2m", "50cm", 30), or "2m,50cm,30"; a number alone is
            in baselines. Default near, middle and far of what the images show. Those at which it is decided are in
            `tolerances`.
    """

    matcher: AbstractMatcher | str | None
    view: AnyView
    prior: Prior
    motion: bool | None
    tolerances: Tolerances | Mapping[str, object] | None
    distances: str | float | Sequence[str | float] | None


class RepairOptions(HealthOptions, total=False):
    """Options of `recalibrate` and `recalibrate_many`, beside those of `HealthOptions`; each is given by name.

    Attributes:
        schedule: a `Schedule`, or "default" (also for None): coarse to fine, the count and then epipolar residuals; or
            "count": compass search on the count at full scale, the paper's way. "count:nlopt-bobyqa" and
            "default:nlopt-bobyqa" name another strategy for the stages of its kind.
        reach: how far the rig may have drifted, a `Reach` or (degrees, fraction of the baseline); default 3 degrees and
            3 % of the baseline.
        budget: units, or a `Budget`, for the whole schedule of a recording; default none.
        seed: for strategies that draw random numbers; default 0.
        free: what may move, `Parameters` or names and groups, such as ("rotation",) or ("extrinsics", "intrinsics");
            default all that the file of the calibration can hold but for the length of the baseline
            (`solution.intrinsics` says what became of the intrinsics); the extrinsics alone where the prior is "exact",
            or the schedule counts. Intrinsics are solved for at the end. Of more than 24 frames so many are chosen, and
            those that ranges name.
        ranges: distances of what single pixels show, each of a pair that is given (the pair itself, or its name); they
            free the length of the baseline, and count beside the rows.
        odometer: how far the rig travelled by wheels or GPS, by the pairs' own clock: with the rig's own motion that
            tells the length of the baseline, which it frees.
    """

    schedule: Schedule | str | None
    reach: Reach | tuple[float, float] | None
    budget: Budget | float | None
    seed: int
    free: Parameters | str | Sequence[str] | None
    ranges: Range | Sequence[Range] | None
    odometer: Odometer | None


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What `RepairOptions` come to: values of one type each, checked, with their defaults.

    Attributes:
        matcher: without its disparity range, if that is to be measured.
        free: with the length of the baseline, if ranges or an odometer free it.
        distances: at which errors of depth are reported; none: those that the images show.
        ranges, view, prior, motion, odometer: as they were given.
    """

    prior: Prior
    matcher: AbstractMatcher
    schedule: Schedule
    reach: Reach
    budget: Budget
    view: AnyView
    seed: int
    free: Parameters
    ranges: tuple[Range, ...]
    motion: bool | None
    tolerances: Tolerances
    distances: tuple[Distance, ...]
    odometer: Odometer | None


def as_settings(options: Mapping[str, Any], names: Collection[str] = RepairOptions.__optional_keys__) -> Settings:
    """The settings that options come to.

    Args:
        options: by name.
        names: that there are; if a schedule is none of them, it is that of a look.

    Raises:
        TypeError: if there is no option of a name; it names the nearest one.
        InputError: if a value makes no sense, or a strategy of the schedule is not installed.
    """
    for name in options:
        if name not in names:
            closest = get_close_matches(name, names, 1)
            meant = f"did you mean {closest[0]}?" if closest else f"there are: {', '.join(sorted(names))}."
            raise TypeError(f"there is no option {name!r}; {meant}")
    given: dict[str, Any] = dict.fromkeys(RepairOptions.__optional_keys__) | dict(options)
    prior, view, odometer, ranges = given["prior"], given["view"], given["odometer"], as_ranges(given["ranges"])
    check_prior(prior)
    if not isinstance(odometer, Odometer | None):
        raise InputError(f"odometer is a {type(odometer).__name__}; give an sr.Odometer(times, metres).")
    return Settings(
        prior=prior,
        matcher=as_matcher(given["matcher"]),
        schedule=as_schedule(given["schedule"]) if "schedule" in names else LOOK,
        reach=as_reach(given["reach"]),
        budget=as_budget(given["budget"]),
        view=checked_view_arguments(view) if isinstance(view, Mapping) else view,
        seed=given["seed"] or 0,
        free=with_ranges(as_parameters(given["free"]), ranges, odometer),
        ranges=ranges,
        motion=given["motion"],
        tolerances=as_tolerances(given["tolerances"]),
        distances=as_distances(given["distances"]),
        odometer=odometer,
    )


def settings_as_data(settings: Settings) -> dict[str, Any]:
    """What a repair computes with, as plain data of the JSON and of a page; a limit that is None is none, a disparity
    range that is None is to be measured."""
    stages = [
        {
            "score": stage.score.name.lower(),
            "scale": stage.scale,
            "strategy": stage.solver,
            "origin": None if stage.strategy is None else origin_of(stage.strategy),
            "options": {} if stage.strategy is None else asdict(stage.strategy),
        }
        for stage in settings.schedule.stages
    ]
    return {
        "free": ("everything",) if settings.free.everything else settings.free.names,
        "matcher": {"name": name_of(settings.matcher), **asdict(settings.matcher)},
        "schedule": settings.schedule.name,
        "stages": stages,
        "seed": settings.seed,
        **{name: asdict(getattr(settings, name)) for name in ("reach", "budget", "tolerances")},
    }
