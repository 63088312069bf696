"""`compare`: strategies x draws x scenes, judged alike."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from typing import Any

import jax
import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError, StrategyError
from stereorecal._run_all import Progress, run_all
from stereorecal._versions import versions
from stereorecal.comparison._comparison import Comparison
from stereorecal.comparison._trial import Task, Trial, failed, run_trial
from stereorecal.geometry import StereoRig, view
from stereorecal.matching import SAD, AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.recalibration import Schedule, recalibrate
from stereorecal.recordings import Pair, Scene, check_pairs
from stereorecal.scoring import prepare, with_disparity_range
from stereorecal.strategies import AbstractStrategy, Budget, Objective, Outcome, origin_of, strategy
from stereorecal.synthetic import decalibrate

SCHEDULES = ("count", "default")


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


def compare(
    rig: StereoRig,
    pairs: Sequence[Pair],
    *,
    strategies: Sequence[str] | Mapping[str, AbstractStrategy] = ("compass",),
    matcher: AbstractMatcher | None = None,
    drift: Drift | None = None,
    reach: Reach | None = None,
    schedule: str = "count",
    scale: float = 1.0,
    draws: int = 20,
    budget: Budget | None = None,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Compare strategies on one scene whose `rig` is the reference. Arguments and errors: see `compare_scenes`."""
    return compare_scenes(
        [Scene("scene", rig, check_pairs(rig, list(pairs)))],
        strategies=strategies,
        matcher=matcher,
        drift=drift,
        reach=reach,
        schedule=schedule,
        scale=scale,
        draws=draws,
        budget=budget,
        seed=seed,
        executor=executor,
        progress=progress,
    )


def compare_scenes(
    scenes: Sequence[Scene],
    *,
    strategies: Sequence[str] | Mapping[str, AbstractStrategy] = ("compass",),
    matcher: AbstractMatcher | None = None,
    drift: Drift | None = None,
    reach: Reach | None = None,
    schedule: str = "count",
    scale: float = 1.0,
    draws: int = 20,
    budget: Budget | None = None,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Decalibrate each scene's rig `draws` times and let every strategy repair each of them.

    All strategies see the same draws, the same matcher with the same disparity range, and the same budget. Errors are
    against the truth where it is known, else against the consensus of the scene's frames (where the default schedule
    ends, started from the stored calibration), else against the stored calibration. Ctrl-C ends the comparison; what is
    finished is returned with `interrupted` set.

    Args:
        scenes: each with a rig, from which the drift is drawn and with which N_GT is counted.
        strategies: names from the registry, or a mapping from names to strategies with options of their own.
        matcher: default `SAD()`; without `num_disparities` each scene's range is measured once.
        drift: default 0.5 degrees and 1 % of the baseline.
        reach: default the larger of 3 degrees, 3 % and 1.2 x the drift.
        schedule: "count": the strategy maximises the count at one scale; "default": coarse to fine, with the strategy
            in the stages of its kind.
        scale: image scale of the count schedule.
        budget: of each trial, in units; default none.
        executor: any `concurrent.futures.Executor`; default one trial after the other in this process.
        progress: called with (finished, total) after each trial.

    Raises:
        InputError: if a scene has no rig, images do not fit, a name is unknown, or there is nothing to do.
    """
    if draws < 1 or not scenes or not strategies:
        raise InputError("there is nothing to compare; give at least one scene, one strategy and one draw.")
    if len({scene.name for scene in scenes}) < len(scenes):
        raise InputError("two scenes have the same name; rename a folder, or give each scene once.")
    if schedule not in SCHEDULES:
        raise InputError(f"unknown schedule {schedule!r}; choose one of: {', '.join(SCHEDULES)}")
    matcher, drift, budget = matcher or SAD(), drift or Drift(), budget or Budget()
    if reach is None:
        reach = Reach(max(3.0, 1.2 * drift.degrees), max(0.03, 1.2 * drift.baseline_fraction))
    chosen = strategies if isinstance(strategies, Mapping) else load_strategies(strategies)
    made_with = versions() | {f"strategy {name}": origin_of(plugin) for name, plugin in chosen.items()}
    planned = [_plan(scene, matcher, reach, scale) for scene in scenes]
    tasks = [
        Task(
            scene=scene,
            reference=reference,
            start=decalibrate(_rig_of(scene), _draw_key(seed, draw), drift.degrees, drift.baseline_fraction),
            draw=draw,
            strategy_name=name,
            matcher_name=type(matcher).__name__.lower(),
            matcher=scene_matcher,
            schedule=Schedule.count(plugin, scale) if schedule == "count" else Schedule.default().using(plugin),
            reach=reach,
            budget=budget,
            seed=seed + draw,
        )
        for scene, scene_matcher, reference in planned
        for draw in range(draws)
        for name, plugin in chosen.items()
    ]
    trials: dict[int, Trial] = {}
    interrupted = False
    try:
        for index, trial in run_all(run_trial, tasks, executor):
            trials[index] = trial if isinstance(trial, Trial) else failed(tasks[index], trial)
            if progress is not None:
                progress(len(trials), len(tasks))
    except KeyboardInterrupt:
        interrupted = True
    settings = {
        "strategies": list(chosen),
        "matcher": {"name": type(matcher).__name__.lower(), **asdict(matcher)},
        "schedule": schedule,
        "scale": scale,
        "decalibrate": asdict(drift),
        "reach": asdict(reach),
        "draws": draws,
        "seed": seed,
        "budget": asdict(budget),
    }
    described = tuple(_describe(*plan) for plan in planned)
    finished = tuple(trials[index] for index in sorted(trials))
    return Comparison(settings, made_with, described, finished, interrupted=interrupted)


@dataclass(frozen=True)
class _Unloadable(AbstractStrategy):
    """Stands for a strategy that is installed but broken, so that its rows are FAILED and the others live."""

    message: str = ""

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], budget: Budget, seed: int) -> Outcome:
        raise StrategyError(self.message)


def load_strategies(names: Sequence[str]) -> dict[str, AbstractStrategy]:
    """The strategies of these names with their default options. One that is installed but broken fails when it runs.

    Raises:
        InputError: if a name is unknown.
    """
    return {name: _load(name) for name in names}


def _load(name: str) -> AbstractStrategy:
    try:
        return strategy(name)
    except StrategyError as error:
        return _Unloadable(str(error))


def _rig_of(scene: Scene) -> StereoRig:
    if scene.rig is None:
        raise InputError(f"{scene.name}: the scene has no calibration; a comparison needs one as reference.")
    return scene.rig


_Plan = tuple[Scene, AbstractMatcher, tuple[StereoRig, str]]


def _plan(scene: Scene, matcher: AbstractMatcher, reach: Reach, scale: float) -> _Plan:
    """The scene, its matcher and its reference; what does not fit is refused now rather than trial by trial."""
    rig = _rig_of(scene)
    pairs = check_pairs(rig, scene.pairs)
    matcher = with_disparity_range(matcher, rig, pairs, view(rig), np.radians(reach.degrees))
    data = prepare(rig, pairs[:1], view(rig), scale)
    matcher.scaled(scale).disparity_range(data.view.size[0])
    return scene, matcher, _reference(scene, rig, matcher)


def _reference(scene: Scene, rig: StereoRig, matcher: AbstractMatcher) -> tuple[StereoRig, str]:
    """The rig that errors are measured against, and what it is worth."""
    if scene.reference != "stored":
        return rig, scene.reference
    try:
        solution = recalibrate(rig, scene.pairs, matcher=matcher)
    except (InputError, StrategyError):  # a strategy of the default schedule is not installed, or broken
        return rig, scene.reference
    return (solution.candidate, "consensus") if solution.reason.healthy else (rig, scene.reference)


def _draw_key(seed: int, draw: int) -> jax.Array:
    return jax.random.fold_in(jax.random.key(seed), draw)


def _describe(scene: Scene, matcher: AbstractMatcher, reference: tuple[StereoRig, str]) -> dict[str, Any]:
    rig = _rig_of(scene)
    return {
        "name": scene.name,
        "image_size": list(rig.left.size),
        "frames": len(scene.pairs),
        "reference": reference[1],
        "baseline_m": float(rig.baseline),
        "min_disparity": matcher.min_disparity,
        "num_disparities": matcher.num_disparities,
    }
