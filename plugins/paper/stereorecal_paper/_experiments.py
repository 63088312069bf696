"""The paper's five experiments (section 4) as lists of tasks."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import jax
import numpy as np

from stereorecal.geometry import StereoRig, with_unit_baseline
from stereorecal.matching import BM, SAD, SGBM, AbstractMatcher, name_of
from stereorecal.objectives import EXTRINSICS, Reach
from stereorecal.recalibration import Schedule
from stereorecal.recordings import Log, Mission, PairSequence, names_of, picked
from stereorecal.strategies import Budget, Need, strategy
from stereorecal.synthetic import decalibrate
from stereorecal_paper._experiment_tasks import (
    AxisSweep,
    Method,
    PairCounts,
    PairRepair,
    Search,
    SequentialRepairs,
    Task,
)
from stereorecal_paper._logged_pair import LoggedPair
from stereorecal_paper._pixel_counter import PixelCounter, counter_of, ideal, unstarred

_AXES = {"pitch": 0, "yaw": 1, "roll": 2, "y": 4, "z": 5}
_UNITS_PER_ITERATION = 2 * len(EXTRINSICS)  # the paper's iteration tries a step either way along each axis
_DRAWN = 4  # wrong calibrations of a log that has one only
_DRIFT = 2.5, 0.0225  # degrees and fraction of the baseline: theirs, as far apart as those of the rendered log
_FAR = 3.0  # degrees, and percent of the baseline, at the ends of a sweep: the default reach
# Of compass on the count, as a fraction of the reach; the paper does not say. With 1/16, the default, two of the 17
# pairs of ex-nihilo never left their start; with 1/8 all ended at r >= 0.99, with 1/4 the lowest at 0.97.
_FIRST_STEP = 1.0 / 8.0
_APART = (
    0.1  # degrees or percent of the baseline: three times the error of a chessboard; what is nearer is the same state
)


@dataclass(frozen=True)
class Extent:
    """The part of a log that the experiments use.

    Attributes:
        missions: sequences, the first ones; None: all.
        images: pairs of each sequence that are repaired.
        starts: wrong calibrations from which one pair is repaired.
        sweeps: pairs through which axes are swept, each of another sequence.
        points: of a sweep.
        matchers: with which axes are swept, and besides with the one that the experiments count with.
        steps: pairs that are repaired one after the other.
        iterations: of each of those, ten evaluations long.
    """

    missions: int | None = None
    images: int = 3
    starts: int = 4
    sweeps: int = 2
    points: int = 31
    matchers: tuple[AbstractMatcher, ...] = (SAD(), BM(), SGBM())
    steps: int = 10
    iterations: int = 50


QUICK = Extent(missions=2, images=1, starts=1, sweeps=1, points=11, matchers=(SAD(), BM()), steps=2, iterations=10)


def methods(names: tuple[str, ...], strategy_name: str | None = None) -> tuple[Method, ...]:
    """The methods of these names: "count" (the paper's way: compass on the count at one scale) and "default" (the
    default schedule). A strategy that is named replaces compass, or the fit between matches if it needs residuals.

    Raises:
        InputError: if a strategy is not installed.
    """
    chosen = None if strategy_name is None else strategy(strategy_name)
    made = {}
    if "count" in names:
        climb = strategy("compass", step=_FIRST_STEP) if chosen is None or chosen.needs is Need.RESIDUALS else chosen
        made["count"] = Method("count", Schedule.count(climb), ranged=True)
    if "default" in names:
        schedule = Schedule.default() if chosen is None else Schedule.default().using(chosen)
        made["default"] = Method("default", schedule, ranged=False)
    return tuple(made[name] for name in names)


@dataclass(frozen=True, eq=False)
class Setting:
    """What all experiments share.

    Attributes:
        matcher: counts pixels and repairs.
        seed: chooses wrong calibrations, images and orders.
    """

    log: Log
    methods: tuple[Method, ...]
    matcher: AbstractMatcher
    extent: Extent
    reach: Reach
    seed: int
    _counters: dict[str, PixelCounter] = field(default_factory=dict, repr=False)

    @property
    def missions(self) -> tuple[Mission, ...]:
        """The first ones, as many as the extent says."""
        return self.log.missions[: self.extent.missions]

    def counter(self, mission: Mission) -> PixelCounter:
        """The pixel counter of a mission; made once."""
        if mission.name not in self._counters:
            self._counters[mission.name] = counter_of(self.log, mission, self.reach, self.matcher)
        return self._counters[mission.name]

    def logged_pairs(self, mission: Mission, pairs: PairSequence) -> list[LoggedPair]:
        """Pairs of a mission, each with the counter."""
        counter = self.counter(mission)
        return [
            LoggedPair(mission.name, pairs[index : index + 1], name in mission.starred, counter)
            for index, name in enumerate(names_of(pairs))
        ]

    def search(self, method: Method, units: float | None = None) -> Search:
        """A method within the reach, and with a budget of so many units."""
        return Search(method, self.reach, Budget(units), self.seed)

    def draw(self, *what: int) -> np.random.Generator:
        """Random numbers for one purpose."""
        return np.random.default_rng([self.seed, *what])

    def wrong(self, mission: Mission) -> dict[str, StereoRig]:
        """Wrong calibrations of a mission: those of other dates that differ from its own, or drawn ones where there are
        none, as in a log of rectified images. The intrinsics are always those of the mission, since they are taken as
        known (paper, section 3.2)."""
        rig = self.log.calibration_of(mission)
        others = {name: rig.with_extrinsics(c.extrinsics) for name, c in self.log.calibrations.items()}
        wrong = {name: other for name, other in others.items() if _apart(rig, other) > _APART}
        if wrong:
            return wrong
        keys = [jax.random.fold_in(jax.random.key(self.seed), index) for index in range(_DRAWN)]
        return {f"drawn-{index}": decalibrate(rig, key, *_DRIFT) for index, key in enumerate(keys)}

    def from_nothing(self, mission: Mission) -> StereoRig:
        """[0, 0, 0, -B, 0, 0], B the mean of all manual calibrations (paper, section 4.4)."""
        baselines = [float(rig.baseline) for rig in self.log.calibrations.values()]
        return ideal(self.log.calibration_of(mission), float(np.mean(baselines)))


def validity(setting: Setting) -> Iterator[Task]:
    """Every pair under every calibration (section 4.1)."""
    for mission in setting.missions:
        known = {mission.calibration: setting.log.calibration_of(mission), **setting.wrong(mission)}
        dates = list(setting.log.calibrations)
        ordered = sorted(known, key=lambda name: dates.index(name) if name in dates else len(dates))
        extrinsics = {name: np.asarray(known[name].extrinsics) for name in ordered}
        for logged_pair in setting.logged_pairs(mission, mission.pairs):
            yield PairCounts(logged_pair, mission.calibration, extrinsics)


def sweeps(setting: Setting) -> Iterator[Task]:
    """One pair of some sequences along every axis, with every matcher (section 4.1); closer steps near the middle."""
    extent, chosen = setting.extent, setting.matcher
    listed = any(type(matcher) is type(chosen) for matcher in extent.matchers)
    named = [(name_of(matcher), matcher) for matcher in (*extent.matchers, *([] if listed else [chosen]))]
    even = np.linspace(-1.0, 1.0, extent.points)
    offsets = tuple((_FAR * np.sign(even) * even**2).tolist())
    for mission in setting.missions[: extent.sweeps]:
        (logged_pair,) = setting.logged_pairs(mission, unstarred(mission)[:1])
        for axis in _AXES.values():
            for name, matcher in named:
                yield AxisSweep(logged_pair, axis, name, matcher, offsets)


def repair(setting: Setting) -> Iterator[Task]:
    """Some pairs of each sequence, each from a calibration of another date (section 4.2)."""
    for index, mission in enumerate(setting.missions):
        draw, wrong = setting.draw(2, index), setting.wrong(mission)
        chosen = draw.permutation(len(mission.pairs))[: setting.extent.images]
        for logged_pair in setting.logged_pairs(mission, picked(mission.pairs, np.sort(chosen).tolist())):
            name = str(draw.choice(list(wrong)))
            yield from _repairs(setting, logged_pair, name, wrong[name])


def generalise(setting: Setting) -> Iterator[Task]:
    """One pair of the last sequence from several calibrations, judged on all others (section 4.3)."""
    mission = max(reversed(setting.missions), key=lambda mission: len(mission.pairs) > 1)
    (logged_pair,), wrong = setting.logged_pairs(mission, unstarred(mission)[:1]), setting.wrong(mission)
    others = tuple(other for other in setting.logged_pairs(mission, mission.pairs) if other.image != logged_pair.image)
    for name in setting.draw(3).permutation(list(wrong))[: setting.extent.starts]:
        yield from _repairs(setting, logged_pair, str(name), wrong[str(name)], others)


def ex_nihilo(setting: Setting) -> Iterator[Task]:
    """The first pairs of each sequence, from no calibration but the baseline (section 4.4)."""
    for mission in setting.missions:
        for logged_pair in setting.logged_pairs(mission, mission.pairs[: setting.extent.images]):
            yield from _repairs(setting, logged_pair, "none", setting.from_nothing(mission))


def sequential(setting: Setting) -> Iterator[Task]:
    """The pairs of the fullest sequence one after the other, from no calibration: in random order, the better half by
    their first score twice over, and all of them twice (section 4.5)."""
    extent = setting.extent
    mission = max(setting.missions, key=lambda mission: len(unstarred(mission)))
    start, counter = setting.from_nothing(mission), setting.counter(mission)
    order = setting.draw(5).permutation(len(mission.pairs))[: extent.steps]
    shuffled = setting.logged_pairs(mission, picked(mission.pairs, order.tolist()))
    first = {
        logged_pair.image: counter.counts(logged_pair.pair, [np.asarray(start.extrinsics)])[0]
        for logged_pair in shuffled
    }
    better = sorted(shuffled, key=lambda logged_pair: first[logged_pair.image], reverse=True)[
        : (len(shuffled) + 1) // 2
    ]
    orders = {"random": shuffled, "better half twice": 2 * better, "random twice": 2 * shuffled}
    for name, logged in orders.items():
        for method in setting.methods:
            limit = float(extent.iterations * _UNITS_PER_ITERATION) if method.name == "count" else None
            yield SequentialRepairs(name, start, setting.search(method, limit), tuple(logged))


def _repairs(
    setting: Setting, logged_pair: LoggedPair, name: str, start: StereoRig, others: tuple[LoggedPair, ...] = ()
) -> Iterator[Task]:
    """A pair from one start, by every method."""
    for method in setting.methods:
        yield PairRepair(logged_pair, name, start, setting.search(method), others)


def _apart(one: StereoRig, other: StereoRig) -> float:
    """The largest difference of an angle [degrees] or of the direction of the baseline [percent]."""
    difference = np.abs(with_unit_baseline(one.extrinsics) - with_unit_baseline(other.extrinsics))
    return float(max(np.degrees(difference[:3]).max(), 100.0 * difference[3:].max()))


EXPERIMENTS = {
    "validity": (validity, sweeps),
    "repair": (repair,),
    "generalise": (generalise,),
    "ex-nihilo": (ex_nihilo,),
    "sequential": (sequential,),
}
"""By name: what plans their tasks."""
