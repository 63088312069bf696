"""Row errors as a median of tiles, and the verdict where the count is all there is."""

from dataclasses import dataclass

import numpy as np

from stereorecal.decision import Reason
from stereorecal.recalibration._row_residuals import RowResiduals


@dataclass(frozen=True, eq=False)
class RowErrors:
    """|Row difference| of the correspondences, pixels at full size: the mean over the tiles of a tile's median.

    Attributes:
        before: under the initial calibration.
        after: under the candidate.
        significance: of the gain, in standard errors over the places of tiles in the frames.
    """

    before: float
    after: float
    significance: float


def row_errors(found: RowResiduals) -> RowErrors:
    """The row errors of what each tile shows, before and after."""
    before, after = found.medians(found.start_residual), found.medians(found.residual)
    gain = found.by_place(before - after)
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain)) if len(gain) > 1 else np.inf
    return RowErrors(float(np.mean(before)), float(np.mean(after)), float(np.mean(gain)) / max(error, 1e-9))


def verdict_on_count(before: int, after: int, *, signal: bool) -> Reason:
    """Where the count is all there is: more is better."""
    if not signal:
        return Reason.TOO_LITTLE_TEXTURE
    return Reason.MORE_MATCHES if after > before else Reason.NOT_IMPROVED
