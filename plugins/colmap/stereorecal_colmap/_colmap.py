"""The strategy, and its options."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Need, Objective, Outcome


@dataclass(frozen=True)
class Colmap(AbstractStrategy):
    """COLMAP: its SIFT features, geometric verification and bundle adjustment of a rig; no score is evaluated.

    Features of the left and the right image of each frame are matched and verified by one calibrated two-view geometry,
    for the rig is the same. The matches are triangulated and the pose of the right camera in the rig is adjusted with
    all points (`refine_sensor_from_rig`), intrinsics constant, once from the initial calibration and once from the
    two-view geometry; points of large error or small angle are filtered and all are triangulated anew, until hardly any
    observation changes. The result that keeps more points counts. All that has an option in COLMAP has COLMAP's
    default, but for points of two images, which COLMAP ignores and single pairs consist of. Frames are not linked over
    time.

    COLMAP moves the whole pose: axes that are held stay as they are all the same, those that are free take its result,
    with the length of the baseline that x gives.

    It spends no units of the budget: a unit is one run of the stereo matcher, and it runs none. A limit in seconds is
    checked between frames.

    Attributes:
        max_reproj_error, min_tri_angle: points of more error [px] or less angle [degrees] are filtered.
        max_refinements, max_refinement_change: rounds of adjustment, and the share of observations below whose change
            they end.
        min_matches: the run ends as STALLED with fewer matches, or fewer points that are kept.
    """

    needs: ClassVar[Need] = Need.IMAGES

    max_reproj_error: float = 4.0
    min_tri_angle: float = 1.5
    max_refinements: int = 5
    max_refinement_change: float = 0.0005
    min_matches: int = 15

    def __post_init__(self) -> None:
        for name in ("max_reproj_error", "max_refinement_change"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"need {name} > 0, got {getattr(self, name)}")
        if not 0.0 <= self.min_tri_angle < 90.0:
            raise ValueError(f"need 0 <= min_tri_angle < 90, got {self.min_tri_angle}")
        if self.max_refinements < 1:
            raise ValueError(f"need max_refinements >= 1, got {self.max_refinements}")
        if self.min_matches < 8:
            raise ValueError(f"need min_matches >= 8, got {self.min_matches}")
        if threading.current_thread() is threading.main_thread():
            with suppress(ImportError), _signals_kept():  # here, since only the main thread may keep signals
                import_module("stereorecal_colmap._fit")  # an error is said by who needs it

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. `seed` is that of the random samples for the two-view geometry."""
        with _signals_kept():
            from stereorecal_colmap._fit import search  # here, since a worker has another process, or another thread
        return search(self, objective, start, seed)


@contextmanager
def _signals_kept() -> Iterator[None]:
    """Around the import of pycolmap, whose logging would abort the process at SIGTERM, with all that it has to save."""
    handler = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        if handler is not None and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, handler)
