"""What benchmarks record of each case, so that other rules can be replayed on it: the estimate, what images show
besides, and a judge of any rig that an estimate never met."""

import pickle
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import simulated_rigs
from stereorecal_boards import Board
from stereorecal_field.judges import DepthByTruth, by_boards, depth_by_truth
from stereorecal_field.judges._rows import followed, row_differences

import stereorecal as sr
from stereorecal.decision import Seen
from stereorecal.estimation import Estimate, points_of_view, readings
from stereorecal.geometry import with_unit_baseline
from stereorecal.scoring import Correspondences, median_row_error, with_rays_of

NEED, ROWS_WORSE, ROWS_CHANGED, DEPTH_WORSE = 0.2, 0.05, 0.02, 1.0  # pixels of rows, percentage points of depth
_VIEW_AT, _FAR = (5, 10, 30), 30  # baselines


@dataclass(frozen=True)
class Errors:
    """The errors of a rig, by truth.

    Attributes:
        rows: epipolar errors, each by another judge, pixels.
        depth: |error| at 30 baselines, percent; NaN: nobody knows.
    """

    rows: tuple[float, ...]
    depth: float = float("nan")

    @property
    def in_need(self) -> bool:
        return bool(np.nanmax(self.rows) > NEED)

    def worse_than(self, other: "Errors", rows_px: float = ROWS_WORSE) -> bool:
        rows = np.nan_to_num(np.subtract(self.rows, other.rows)).max()
        return bool(rows > rows_px or self.depth > other.depth + DEPTH_WORSE)


@dataclass(frozen=True, eq=False)
class Case:
    """What is decided on, and who judges what comes of it.

    Attributes:
        bench, name: of what it is a part.
        estimate: None: too little matches.
        free: what may change.
        seen: besides.
        start: the calibration.
        judge: of rigs.
    """

    bench: str
    name: str
    estimate: Estimate | None
    free: tuple[str, ...]
    seen: Seen | None
    start: sr.StereoRig
    judge: Callable[[sr.StereoRig], Errors]

    @classmethod
    def of(cls, bench: str, name: str, solution: sr.Solution, judge: Callable[[sr.StereoRig], Errors]) -> "Case":
        """What a repair rests on."""
        free = solution.settings.free.names
        return cls(bench, name, solution.estimate, free, solution.seen, solution.initial, judge)

    def record(self, folder: Path | None) -> None:
        """In a file of its own."""
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            path = folder / f"{self.bench}-{zlib.crc32(f'{self.bench} {self.name}'.encode()):08x}.pickle"
            path.write_bytes(pickle.dumps(self))


def recorded(folder: Path) -> Iterator[Case]:
    """All cases of a folder, in the order of their names."""
    for path in sorted(folder.glob("*.pickle")):
        yield pickle.loads(path.read_bytes())


# Judges.


@dataclass(frozen=True, eq=False)
class BySimulation:
    """The rig of a seed: root mean square rows over the view at 5, 10 and 30 baselines, on average."""

    seed: int
    kind: str
    degrees: float

    def __call__(self, rig: sr.StereoRig) -> Errors:
        return simulated_errors(simulated_rigs.simulated(self.seed, self.kind, self.degrees), rig)


def simulated_errors(truth: simulated_rigs.Simulated, rig: sr.StereoRig) -> Errors:
    """The errors of a rig, by a simulated one that is true."""
    rows = truth.rows_px(rig, tuple(map(float, _VIEW_AT)), rms=True)
    return Errors((float(rows.mean()),), float(truth.absolute_depth_error_percent(rig, (float(_FAR),))[0]))


@dataclass(frozen=True, eq=False)
class ByTrueRig:
    """A rig that is true: rows of matches of clean images; over the view and in depth, too, if it is `known`, and not
    the consensus of repairs."""

    true: sr.StereoRig
    matches: Correspondences
    known: bool

    def __call__(self, rig: sr.StereoRig) -> Errors:
        seen = with_rays_of(rig, self.matches, matched_rig=self.true)
        rows = float(median_row_error(seen, with_unit_baseline(rig.extrinsics)))
        if not self.known:
            return Errors((rows,))
        over_view = [np.mean(np.abs(readings(rig, self.true, points_of_view(self.true, d))[0])) for d in _VIEW_AT]
        _, nearness = readings(rig, self.true, points_of_view(self.true, _FAR))
        depth = 100.0 * float(np.median(np.abs(1.0 / np.maximum(1.0 + nearness, 0.1) - 1.0)))
        return Errors((rows, float(np.mean(over_view))), depth)


@dataclass(frozen=True, eq=False)
class ByCorners:
    """Corners that Lucas-Kanade followed, raw pixels, of scenes that took no part: median rows of each scene, and the
    median of those."""

    stored: sr.StereoRig
    corners: Sequence[tuple[np.ndarray, np.ndarray]]

    @classmethod
    def of(cls, stored: sr.StereoRig, scenes: Sequence[sr.Scene]) -> "ByCorners":
        return cls(stored, [followed(stored, pair) for scene in scenes for pair in scene.pairs])

    def __call__(self, rig: sr.StereoRig) -> Errors:
        rows = [np.median(np.abs(row_differences(rig, self.stored, *of_scene))) for of_scene in self.corners]
        return Errors((float(np.median(rows)),))


@dataclass(frozen=True, eq=False)
class ByChessboards:
    """Boards: root mean square rows, and depth by the sides of squares."""

    stored: sr.StereoRig
    boards: Sequence[Board]

    def __call__(self, rig: sr.StereoRig) -> Errors:
        found = by_boards(rig, self.stored, self.boards)
        return Errors((found.rows_rms_px,), abs(found.depth_error_percent(_FAR)))


@dataclass(frozen=True, eq=False)
class ByDepth:
    """Lidar, or dense truth: rows of followed corners, and depth."""

    stored: sr.StereoRig
    scene: sr.Scene

    def __call__(self, rig: sr.StereoRig) -> Errors:
        found: DepthByTruth = depth_by_truth(rig, self.stored, self.scene)
        return Errors((found.rows_px,), found.at_30_percent)


@dataclass(frozen=True, eq=False)
class BySift:
    """Rows of SIFT's matches."""

    matches: tuple[np.ndarray, np.ndarray]

    def __call__(self, rig: sr.StereoRig) -> Errors:
        from sift_rows import sift_rows

        return Errors((sift_rows(rig, self.matches),))
