"""One verdict for all candidates with rows: those of single repairs, of strategies that search lenses, of recordings
solved together."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Int

from stereorecal.recalibration._acceptance import RowErrors, Verdict, verdict
from stereorecal.recalibration._evidence import Evidence
from stereorecal.recalibration._misfit import Misfit, misfit

_SHIFTS = ("y", "z")


def judged(
    facts: Evidence,
    names: Sequence[str],
    own: int,
    counts: Int[np.ndarray, "2 k tiles"],
    rows: RowErrors,
    covered: float,
    *,
    settled: Sequence[str] = (),
) -> tuple[Verdict, Misfit]:
    """The verdict on a candidate, and its misfit.

    Args:
        facts: its evidence.
        names: of all parameters, the extrinsics first.
        own: how many of them are extrinsics.
        counts: of the tiles, under the initial calibration and the candidate.
        covered: as `verdict` has it.
        settled: parameters that something else than rows and priors determines: they may lie anywhere.
    """
    left = misfit(facts.only(slice(own)), *counts)
    if any("." in name for name in names):
        # Where lenses change, extrinsics follow along axes that rows hardly see, and every drift would be strange: what
        # vouches for those are rows that took no part.
        left = replace(left, chance=1.0)
    bounded = facts.only(np.array([name not in settled for name in names]))
    shifts = [abs(z) for z, name in zip(facts.z.tolist(), names, strict=True) if name in _SHIFTS]
    shift = max(shifts, default=np.inf)  # where they are held, that they stay says nothing
    return verdict(counts.sum(axis=(1, 2)), rows, bounded, left, covered, shift / facts.prior), left
