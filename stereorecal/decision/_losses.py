"""What a rig loses in rows and depth, by what is known of it, and the chance that a change makes it worse."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.decision._tolerances import DEFAULT, Tolerances
from stereorecal.estimation import Estimate


@dataclass(frozen=True, eq=False)
class Losses:
    """What a rig loses, if each of some rigs drawn from the posterior is the truth.

    Attributes:
        rows: pixels, at each distance.
        depth: percent, at the farthest.
        frame_rows_px: |row difference| of the matches of each frame, on average.
    """

    rows: Float[np.ndarray, "d s"]
    depth: Float[np.ndarray, "s"]
    frame_rows_px: Float[np.ndarray, "f"]

    @property
    def expected(self) -> float:
        """On average: rows over what a matcher notices, and depth over a point; the same whatever is asked."""
        return float(np.mean(self.mean_rows / DEFAULT.gain_px + self.depth / DEFAULT.worse_depth_points))

    @property
    def mean_rows(self) -> Float[np.ndarray, "s"]:
        """Over the distances."""
        return np.mean(self.rows, axis=0)


def losses_of(estimate: Estimate, theta: Float[np.ndarray, "n"]) -> Losses:
    """What the rig at θ loses."""
    return Losses(*estimate.losses(theta), estimate.rows_of_frames(theta))


def with_nearest_distance(estimate: Estimate, tolerances: Tolerances) -> Estimate:
    """An estimate, to be judged at the distances that are asked for, and at the nearest that its images show, if that
    is nearer."""
    nearest, distances = estimate.nearest, tolerances.distances
    judged_at = (nearest, *distances) if nearest < distances[0] else distances
    return estimate if estimate.judged_at == judged_at else replace(estimate, judged_at=judged_at)


def chance_of_harm(estimate: Estimate, theta: Float[np.ndarray, "n"], tolerances: Tolerances | None = None) -> float:
    """Probability that a change makes rows or depth worse; of a calibration whose rows blind the matcher, rows, if the
    change explains them."""
    limits = DEFAULT if tolerances is None else tolerances
    estimate = with_nearest_distance(estimate, limits)
    return counted_harm(losses_of(estimate, np.zeros_like(theta)), losses_of(estimate, theta), limits)


def counted_harm(initial: Losses, after: Losses, limits: Tolerances) -> float:
    """Probability of the harm that counts."""
    worse, rows_worse = chances_of_harm(initial, after, limits)
    return rows_worse if rows_count_alone(initial, after, limits) else worse


def chances_of_harm(initial: Losses, after: Losses, limits: Tolerances) -> tuple[float, float]:
    """Probability that rows or depth become worse, and that rows do."""
    # NaN is no proof of harmlessness.
    lost = ~np.all(after.rows <= initial.rows + limits.worse_rows_px, axis=0)
    farther = ~(after.depth <= initial.depth + limits.worse_depth_points)
    return float(np.mean(lost | farther)), float(np.mean(lost))


def rows_count_alone(initial: Losses, after: Losses, limits: Tolerances, *, left_to_intrinsics: bool = False) -> bool:
    """Whether there is no depth to lose: the calibration's rows blind the matcher, and the candidate explains them.
    What leaves them misaligned may be wrong about anything.

    Args:
        left_to_intrinsics: whether intrinsics that stay explain the rows that it leaves.
    """
    understood = left_to_intrinsics or bool(np.median(after.mean_rows) <= limits.good_rows_px)
    return understood and float(np.mean(initial.mean_rows > limits.blind_rows_px)) > 1.0 - limits.alpha
