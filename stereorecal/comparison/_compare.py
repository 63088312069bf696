"""`compare`: strategies x draws x scenes, judged alike."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from typing import Any, TypedDict, Unpack

import jax
import numpy as np

from stereorecal._errors import InputError, StrategyError
from stereorecal._run_all import Progress, run_all
from stereorecal._version import versions
from stereorecal.comparison._comparison import Comparison
from stereorecal.comparison._entrants import entrants_of
from stereorecal.comparison._trial import JudgedScene, Task, Trial, failed, run_trial
from stereorecal.estimation import EXACT
from stereorecal.geometry import StereoRig, checked_rig
from stereorecal.matching import AbstractMatcher, as_matcher, name_of, origin_of as origin_of_matcher
from stereorecal.objectives import Parameters, Reach, as_parameters, as_reach
from stereorecal.recalibration import recalibrate
from stereorecal.recordings import Pairs, Scene, check_pairs
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import with_measured_range
from stereorecal.strategies import AbstractStrategy, Budget, as_budget, origin_of
from stereorecal.synthetic import decalibrate


@dataclass(frozen=True)
class Drift:
    """How far the rigs are decalibrated: uniform on each axis, within these limits.

    Attributes:
        degrees: on pitch, yaw and roll.
        baseline_fraction: on y and z.
    """

    degrees: float = 0.5
    baseline_fraction: float = 0.01

    def __post_init__(self) -> None:
        # At most what the default reach of 1.2 x the drift can still cover.
        if not (0 <= self.degrees <= 16 and 0 <= self.baseline_fraction <= 0.4):
            raise InputError(
                f"a drift of {self.degrees} degrees and {self.baseline_fraction} of the baseline makes no sense; "
                "give up to 16 degrees and up to 0.4."
            )


class ComparisonOptions(TypedDict, total=False):
    """Options of `compare` and `compare_scenes`; each is given by name.

    Attributes:
        strategies: names from the registry, or a mapping from names to strategies with options of their own; default
            those of the schedule.
        matcher: a matcher, or the name of an installed one (default "sad"); without `num_disparities` each scene's
            range is measured once.
        drift: default 0.5 degrees and 1 % of the baseline.
        reach: a `Reach` or (degrees, fraction of the baseline); default the larger of 3 degrees, 3 % and 1.2 x the
            drift.
        schedule: "count": the strategy maximises the count at one scale; "default": coarse to fine, with the strategy
            in the stages of its kind. Default "count" where strategies are given, else both side by side.
        scale: image scale of the count schedule; default 1.
        draws: drifts of each scene; default 20.
        budget: of each trial, in units or a `Budget`; default none.
        seed: of the drifts, and of strategies; default 0.
        free: what the strategies search, `Parameters` or names and groups, such as ("extrinsics", "intrinsics");
            default the extrinsics. With more than those the box has more coordinates, and the count is scored on the
            host: strategies that need more of it are skipped. Drifts and errors are those of the extrinsics all the
            same.
    """

    strategies: Sequence[str] | Mapping[str, AbstractStrategy] | None
    matcher: AbstractMatcher | str | None
    drift: Drift | None
    reach: Reach | tuple[float, float] | None
    schedule: str | None
    scale: float
    draws: int
    budget: Budget | float | None
    seed: int
    free: Parameters | str | Sequence[str] | None


def compare(
    rig: StereoRig,
    pairs: Pairs,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
    **options: Unpack[ComparisonOptions],
) -> Comparison:
    """Compare strategies on one scene, from whose `rig` the drift is drawn. Arguments and errors: `compare_scenes`."""
    rig = checked_rig(rig)
    scene = Scene("scene", rig, check_pairs(rig, pairs))
    return compare_scenes([scene], executor=executor, progress=progress, **options)


def compare_scenes(
    scenes: Sequence[Scene],
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
    on_trial: Callable[[Comparison], None] | None = None,
    **options: Unpack[ComparisonOptions],
) -> Comparison:
    """Decalibrate each scene's rig `draws` times and let every strategy repair each of them.

    All strategies see the same draws, the same matcher with the same disparity range, and the same budget. The
    reference, with which N_GT is counted and against which errors are, is the truth where it is known, else the
    consensus of the scene's frames (where the default schedule ends, started from the stored calibration), else the
    stored calibration. Ctrl-C ends the comparison; what is finished is returned with `interrupted` set.

    Args:
        scenes: each with a rig, from which the drift is drawn.
        executor: any `concurrent.futures.Executor`; default one trial after the other in this process.
        progress: called with (finished, total) after each trial.
        on_trial: called with what is finished after each trial, such as to save it; `interrupted` is set in it.
        options: those of `ComparisonOptions`, by name.

    Raises:
        InputError: if a scene has no rig, images do not fit, a name is unknown, or there is nothing to do.
        TypeError: if there is no option of a name.
    """
    tasks, nothing = _planned(scenes, **options)
    trials: dict[int, Trial] = {}

    def so_far() -> Comparison:
        return replace(nothing, trials=tuple(trials[index] for index in sorted(trials)))

    try:
        for index, trial in run_all(run_trial, tasks, executor):
            trials[index] = trial if isinstance(trial, Trial) else failed(tasks[index], trial)
            if progress is not None:
                progress(len(trials), len(tasks))
            if on_trial is not None:
                on_trial(so_far())
    except KeyboardInterrupt:
        return so_far()
    return replace(so_far(), interrupted=False)


def _planned(
    scenes: Sequence[Scene],
    *,
    strategies: Any = None,
    matcher: Any = None,
    drift: Drift | None = None,
    reach: Any = None,
    schedule: Any = None,
    scale: float = 1.0,
    draws: int = 20,
    budget: Any = None,
    seed: int = 0,
    free: Any = None,
) -> tuple[list[Task], Comparison]:
    """All trials that there will be, and the comparison before the first of them."""
    if draws < 1 or not scenes or (strategies is not None and not strategies):
        raise InputError("there is nothing to compare; give at least one scene, one strategy and one draw.")
    if not 0.0 < scale <= 1.0:
        raise InputError(f"scale is {scale}; give one within (0, 1].")
    if len({scene.name for scene in scenes}) < len(scenes):
        raise InputError("two scenes have the same name; rename a folder, or give each scene once.")
    matcher, drift, budget, free = as_matcher(matcher), drift or Drift(), as_budget(budget), as_parameters(free)
    if not free.axes:
        raise InputError("no extrinsics are free; free them as well, since every drift moves them.")
    usual = max(3.0, 1.2 * drift.degrees), max(0.03, 1.2 * drift.baseline_fraction)
    reach = as_reach(usual if reach is None else reach)
    entrants = entrants_of(strategies, schedule, scale)
    made_with = versions() | {
        f"strategy {name}": origin_of(plugin) for entrant in entrants for name, plugin in entrant.running.items()
    }
    made_with[f"matcher {name_of(matcher)}"] = origin_of_matcher(matcher)
    judged = [_judged_scene(scene, matcher, reach, scale) for scene in scenes]
    keys = [jax.random.fold_in(jax.random.key(seed), draw) for draw in range(draws)]
    tasks = [
        Task(one, entrant, start, draw, reach, budget, seed + draw, free)
        for one in judged
        for draw, start in enumerate(decalibrate(one.rig, key, **asdict(drift)) for key in keys)
        for entrant in entrants
    ]
    settings = {
        "strategies": list(dict.fromkeys(entrant.name for entrant in entrants)),
        "entrants": [entrant.as_dict() for entrant in entrants],
        "matcher": {"name": name_of(matcher), **asdict(matcher)},
        "schedule": " and ".join(sorted({entrant.schedule.name for entrant in entrants})),
        "scale": scale,
        "decalibrate": asdict(drift),
        "reach": asdict(reach),
        "draws": draws,
        "seed": seed,
        "budget": asdict(budget),
        "free": list(free.names),
    }
    # Of each scene the pair that is shown, and not a whole recording.
    shown = {one.scene.name: replace(one, scene=replace(one.scene, pairs=one.scene.pairs[:1])) for one in judged}
    return tasks, Comparison(settings, made_with, tuple(map(_described, judged)), (), interrupted=True, shown=shown)


def _judged_scene(scene: Scene, matcher: AbstractMatcher, reach: Reach, scale: float) -> JudgedScene:
    """The scene with its matcher and its reference; what does not fit is refused now rather than trial by trial."""
    if scene.rig is None:
        raise InputError(f"{scene.name}: the scene has no calibration; a comparison needs one as reference.")
    images = pyramid(scene.rig, scene.pairs)
    matcher = with_measured_range(matcher, images, float(np.radians(reach.degrees)))
    matcher.scaled(scale).disparity_range(images.at(scale, 1).view.size[0])
    return JudgedScene(scene, scene.rig, matcher, *_reference(scene, scene.rig, matcher))


def _reference(scene: Scene, rig: StereoRig, matcher: AbstractMatcher) -> tuple[StereoRig, str]:
    """The rig that N_GT is counted with and errors are measured against, and what it is worth."""
    if scene.reference != "stored":
        return rig, scene.reference
    try:
        solution = recalibrate(rig, scene.pairs, matcher=matcher, prior=EXACT)
    except (InputError, StrategyError):  # a strategy of the default schedule is not installed, or broken
        return rig, scene.reference
    return (solution.candidate, "consensus") if solution.reason.healthy else (rig, scene.reference)


def _described(judged: JudgedScene) -> dict[str, Any]:
    return {
        "name": judged.scene.name,
        "image_size": list(judged.rig.left.size),
        "frames": len(judged.scene.pairs),
        "reference": judged.worth,
        "baseline_m": float(judged.rig.baseline),
        "min_disparity": judged.matcher.min_disparity,
        "num_disparities": judged.matcher.num_disparities,
    }
