"""The parameters that a repair frees where nothing is said: the extrinsics, or all where frames bear that out."""

from stereorecal.decision import Decision, decide
from stereorecal.estimation import Estimate
from stereorecal.objectives import Parameters
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._cross_validated_decision import (
    asks_for_intrinsics,
    decided_by_cross_validation,
    shows_several_places,
)
from stereorecal.scoring import Correspondences


def free_and_decision(case: Case, found: Correspondences, estimate: Estimate) -> tuple[Parameters, Decision]:
    """What may change, and the decision on it: as it is in the case; or everything, where that does not explain the
    rows of several places, and all parameters together do, also in frames that took no part. Where there are fewer
    places, nothing refutes intrinsics that explain what the extrinsics leave. What a late shutter leaves, they do not
    explain.

    Args:
        found: that the estimate rests on.
    """
    held = decide(estimate, case.free.names, case.tolerances)
    if not (case.free.widens and asks_for_intrinsics(estimate, held)):
        return case.free, held
    if not shows_several_places(estimate):
        return case.free, decide(estimate, case.free.names, case.tolerances, intrinsics_explain=True)
    free = case.free.widest(case.rig)
    freed = decided_by_cross_validation(estimate, found, case.rig, case.prior, free.names, case.tolerances)
    return (case.free, held) if freed is None else (free, freed)
