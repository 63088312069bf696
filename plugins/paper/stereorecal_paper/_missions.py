"""A synthetic log of missions like that of the paper: one boat, seven years, eleven manual calibrations.

The paper is J. Muhovič and J. Perš, Correcting Decalibration of Stereo Cameras in Self-Driving Vehicles, section 4.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import date, timedelta

import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.recordings import Mission
from stereorecal.synthetic import default_rig, render

# The paper's identifiers of calibrations (tables 1 and 2), and how many pairs the sequence taken after each one has.
_CALIBRATIONS = (57, 60, 65, 67, 71, 90, 94, 96, 99, 103, 104)
_PAIRS = {60: 8, 65: 8, 67: 9, 71: 10, 90: 7, 103: 10, 104: 8}
# Pairs, counted from 1, that look to the open sea: those starred in table 2, and three more of our choice.
_OPEN_SEA = {65: (2,), 67: (6,), 71: (2, 3), 90: (3,), 103: (7,), 104: (8,)}
_FIRST, _BETWEEN = date(2012, 4, 10), timedelta(days=256)  # chosen: eleven calibrations span seven years
# Largest deviation from the mean rig: half of the 2.5 degrees and 8 mm per axis by which two states may differ (paper).
_DRIFT = np.array([*np.radians([1.25] * 3), 0.0, 0.004, 0.004])
_CHESSBOARD = (
    np.radians(0.03),
    0.001,
)  # chosen rms error of a manual calibration: [rad], fraction of the baseline


@dataclass(frozen=True, eq=False)
class PlannedMission:
    """A mission before its pairs are rendered.

    Attributes:
        mission: the mission without its pairs; `truth` is the rig that takes them.
        kinds: kind of scene of each pair; the pairs are named "001.png" and so on.
        seeds: seed of each scene.
    """

    mission: Mission
    kinds: tuple[str, ...]
    seeds: tuple[int, ...]

    def photographed(self) -> Mission:
        """The mission with its pairs rendered; the same plan gives the same images."""
        takes = enumerate(zip(self.kinds, self.seeds, strict=True), 1)
        pairs = [
            replace(render(kind, seed, rig=self.mission.truth).pairs[0], name=_name(number))
            for number, (kind, seed) in takes
        ]
        return replace(self.mission, pairs=tuple(pairs))


@dataclass(frozen=True, eq=False)
class MissionPlan:
    """What `plan_missions` returns.

    Attributes:
        calibrations: the manual calibrations by ISO date, in chronological order.
        missions: in chronological order.
    """

    calibrations: Mapping[str, StereoRig] = field(repr=False)
    missions: tuple[PlannedMission, ...] = field(repr=False)


def plan_missions(seed: int = 0, *, rig: StereoRig | None = None, most_pairs: int | None = None) -> MissionPlan:
    """Plan sixty pairs in seven sequences of harbours, coasts and open sea, and eleven manual calibrations.

    The true rig at each calibration is drawn around `rig`, so that any two differ by at most 2.5 degrees and 8 mm on
    each axis. A manual calibration adds the error of a chessboard calibration (rms 0.03 degrees and 0.1 % of the
    baseline); the true rig is `Mission.truth`.

    Args:
        seed: of the random drift, calibration errors and scenes.
        rig: the mean rig (default: `default_rig()`).
        most_pairs: keep only the first so many pairs of each sequence (default: all).
    """
    draw = np.random.default_rng([seed, 11])
    rig = rig or default_rig()
    calibrations: dict[str, StereoRig] = {}
    missions = []
    for index, number in enumerate(_CALIBRATIONS):
        day = _FIRST + index * _BETWEEN
        truth = rig.with_extrinsics(rig.extrinsics + _DRIFT * draw.uniform(-1.0, 1.0, 6))
        calibrations[day.isoformat()] = _calibrated(truth, draw)
        if number in _PAIRS:
            missions.append(_planned(number, day, truth, draw, most_pairs))
    return MissionPlan(calibrations, tuple(missions))


def _planned(
    number: int, day: date, truth: StereoRig, draw: np.random.Generator, most_pairs: int | None
) -> PlannedMission:
    open_sea = _OPEN_SEA.get(number, ())
    shores = draw.choice(["harbour", "coast"], _PAIRS[number])
    kinds = [str(shore) if image not in open_sea else "open-sea" for image, shore in enumerate(shores, 1)][:most_pairs]
    seeds = draw.integers(0, 2**31, _PAIRS[number])[:most_pairs]
    mission = Mission(
        name=f"{day + timedelta(days=1)}-kope{number}",
        calibration=day.isoformat(),
        pairs=(),
        starred=frozenset(_name(image) for image, kind in enumerate(kinds, 1) if kind == "open-sea"),
        truth=truth,
    )
    return PlannedMission(mission, tuple(kinds), tuple(map(int, seeds)))


def _calibrated(truth: StereoRig, draw: np.random.Generator) -> StereoRig:
    angle, share = _CHESSBOARD
    sizes = np.array([angle] * 3 + [share * float(truth.baseline)] * 3)
    return truth.with_extrinsics(truth.extrinsics + sizes * draw.standard_normal(6))


def _name(image: int) -> str:
    return f"{image:03d}.png"
