"""Simulated drives for `motion.py`: tracks without images, of rigs whose truth is known, and what is made of them."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import simulated_rigs
from recorded import ROWS_CHANGED, simulated_errors
from simulated_scenes import inverse_depth
from tables import show, table_of

from stereorecal.decision import Verdict, decide
from stereorecal.estimation import Estimate, Windows, as_prior, estimate, rig_parameters
from stereorecal.geometry import rotation_from_vector
from stereorecal.objectives import EXTRINSICS
from stereorecal.scoring import Correspondences, Tracks

DRIFTS = (("none", 0.0), ("all", 0.3), ("all", 2.5))
USUAL = DRIFTS[1]
ROWS, FRAMES = "rows alone", 3


@dataclass(frozen=True)
class Case:
    """How the rig moves, and what else does.

    Attributes:
        move: of points as the left camera has them, baselines from one pair to the next; a window's is half of it to
            five quarters.
        turn: standard deviations of the rotation vector, radians.
        with_rig: share of the near half of all points that goes with the rig.
        convoy: whether what fills the middle of the view, ten baselines away, does.
        wall: whether all that is seen is a wall, twelve baselines away.
        wrong: share of tracks that are.
        noise: of the tracks, in that of good images.
        late: by which the right shutter is, of the time between two pairs.
    """

    move: tuple[float, float, float] = (0.02, 0.01, -1.0)
    turn: float = 0.004
    with_rig: float = 0.0
    convoy: bool = False
    wall: bool = False
    wrong: float = 0.1
    noise: float = 1.0
    late: float = 0.0

    def way(self, rig: simulated_rigs.Simulated, draw: int, share: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """How points move in a share of the time of one window: a rotation, and a translation after it [m]."""
        rng = np.random.default_rng([rig.seed, 78, draw])
        turn, speed = self.turn * rng.normal(size=3), rng.uniform(0.5, 1.25)
        length = float(np.linalg.norm(rig.translation))
        rotation = np.asarray(rotation_from_vector(share * turn), float)
        return rotation, share * length * speed * np.array(self.move)


CASES = {
    "ahead": Case(),
    "traffic": Case(with_rig=0.5),
    "convoy": Case(convoy=True),
    "rain": Case(wrong=0.35, noise=2.0),
    "sideways": Case(move=(-1.0, 0.02, 0.0)),
    "a wall": Case(wall=True),
    "at rest": Case(move=(0.0, 0.0, 0.0), turn=0.0),
    "turning only": Case(move=(0.0, 0.0, 0.0), turn=0.03),
    "turning and slowly ahead": Case(move=(0.02, 0.01, -0.15), turn=0.03),
    "late by 0.2": Case(turn=0.01, late=0.2),
}


def tracks_of(rig: simulated_rigs.Simulated, draw: int, case: Case) -> Tracks:
    """One window: the scene's points, with errors that neighbours have in common."""
    rng = np.random.default_rng([rig.seed, 77, draw])
    size, baseline = np.array(rig.calibrated.left.size, float), float(np.linalg.norm(rig.translation))
    left = rng.uniform(0.0, 1.0, (1000, 2)) * (size - 1.0)
    rays = rig.left.rays(left)
    near = inverse_depth(rays, rng) if not case.wall else np.full(len(rays), 1.0 / 12.0)
    stays = (near > np.nanmedian(near)) & (rng.random(len(near)) < case.with_rig)
    if case.convoy:
        vehicle = (np.abs(left / size - 0.5) < [0.25, 0.2]).all(axis=1)
        near, stays = np.where(vehicle, 0.1, near), stays | vehicle
    points = rays / near[:, None] * baseline
    turn, move = case.way(rig, draw)
    later = points @ turn.T + move
    later[stays] = points[stays] + 0.02 * baseline * rng.normal(size=3)
    shown = [rig.left.pixels(some) for some in (points, later)]
    turn, move = case.way(rig, draw, case.late)
    partners = [rig.right.pixels((p @ turn.T + move) @ rig.rotation.T + rig.translation) for p in (points, later)]
    cells = tuple((left / size * [14, 9]).astype(int).T)

    def shared() -> np.ndarray:
        return rng.normal(0.0, 0.04, (14, 9, 2))[cells]

    tracking = case.noise * (rng.normal(0.0, 0.08, left.shape) + shared())
    shown[1] = shown[1] + tracking
    disparity = shared() + rng.normal(0.0, 0.06, left.shape)  # the same at both times
    for index in (0, 1):
        partners[index] += case.noise * (disparity + rng.normal(0.0, 0.08, left.shape)) + index * tracking
    wrong = rng.random(len(left)) < case.wrong
    shown[1][wrong] += rng.uniform(-3.0, 3.0, (wrong.sum(), 2))
    good = np.isfinite(np.column_stack([rays, *shown, *partners])).all(axis=1)
    return Tracks(np.stack([left, shown[1]]), np.stack(partners)).of(good)


def late_rows(rig: simulated_rigs.Simulated, case: Case, windows: int) -> Correspondences:
    """What a late shutter makes of a frame of each window."""
    return rig.correspondences(windows, late=[case.way(rig, draw, case.late) for draw in range(windows)])


@dataclass(frozen=True)
class Judged:
    """One estimate: whether the 95 % interval of disparity at 30 baselines of the posterior's mean holds the truth, its
    |error of depth| there in percent, whether a repair would be written, whether it harms, and the delay of the right
    shutter that is more probable than none, 0 if there is none."""

    held: bool
    error: float
    accepted: bool
    harmful: bool
    delay: float


def judged(rig: simulated_rigs.Simulated, seen: Estimate) -> Judged:
    """By the truth."""
    (error,) = rig.depth_error_percent(seen.chart.rig_at(seen.theta), [30.0])
    _, low, high = seen.depth_error_percent(seen.theta)[30]
    decision = decide(seen, EXTRINSICS)
    accepted = decision.verdict is Verdict.REPAIR
    before, after = (simulated_errors(rig, one) for one in (rig.calibrated, seen.chart.rig_at(decision.theta)))
    harmful = accepted and after.worse_than(before, ROWS_CHANGED)
    delay = seen.delay.seconds if seen.delay and seen.delay.probability > 0.5 else 0.0
    return Judged(low <= error <= high, abs(error), accepted, harmful, delay)


def row(name: str, drift: tuple[str, float], found: list[Judged]) -> tuple[str, ...]:
    """Of the table."""
    error = np.quantile([one.error for one in found], (0.5, 0.95), method="higher")
    held, accepted, harmful = (sum(getattr(one, part) for one in found) for part in ("held", "accepted", "harmful"))
    delays = " ".join(f"{np.quantile([one.delay for one in found], share):+.3f}" for share in (0.0, 0.5, 1.0))
    share, errors = f"{100.0 * held / len(found):.0f} %", " ".join(f"{one:.2f}" for one in error)
    return name, f"{drift[0]} {drift[1]:g}°", f"{len(found)}", share, errors, f"{accepted}", f"{harmful}", delays


def simulated(rigs: int, first: int, windows: int, cases: Sequence[str]) -> None:
    """Windows of each rig, in some cases."""
    heads = "motion | drift | rigs | held | |depth error| at 30 B, %: median, 95th | accepted | harmful"
    table = table_of(f"{heads} | delay: least, median, most", left=2)
    told: dict[tuple[str, tuple[str, float]], list[Judged]] = defaultdict(list)
    for seed in range(first, first + 2 * rigs, 2):
        for drift in DRIFTS:
            rig = simulated_rigs.simulated(seed, *drift)
            prior = as_prior(None, rig_parameters(rig.calibrated))
            rows = rig.correspondences(FRAMES)
            if ROWS in cases:
                told[ROWS, drift].append(judged(rig, estimate(rows, rig.calibrated, prior)))
            for name, case in CASES.items():
                if name in cases and (name == "ahead" or drift == USUAL):
                    some = rows if not case.late else late_rows(rig, case, windows)
                    tracks = tuple(tracks_of(rig, draw, case) for draw in range(windows))
                    frames = tuple((draw % len(some.weight),) * 2 for draw in range(windows))
                    seen = Windows(tracks, frames, (1.0,) * windows)
                    told[name, drift].append(judged(rig, estimate(some, rig.calibrated, prior, windows=seen)))
    for name in (ROWS, *CASES):
        for drift in DRIFTS:
            if (name, drift) in told:
                table.add_row(*row(name, drift, told[name, drift]))
    show(table)
