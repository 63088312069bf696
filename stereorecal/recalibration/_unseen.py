"""Cross-validation of recordings that are solved together: rows judged by solutions that have not seen them."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from stereorecal.recalibration._evidence import FOLDS, TILES_OF_A_FRAME, Evidence, fold_of
from stereorecal.recalibration._joint import Joint, Member, joint
from stereorecal.recalibration._sums import Sums

Medians = Float[np.ndarray, "t"]  # of |row differences|, for each tile of a member


def by_place(members: Sequence[Member], own: int) -> tuple[Medians, ...]:
    """Each tile under a solution that saw none of any member's tiles at its place, nor at a quarter of the others."""
    problem = joint(members, own)
    shifts = [problem.shift(lambda _, part, f=fold: fold_of(part.place) != f) for fold in range(FOLDS)]
    medians = []
    for index, member in enumerate(members):
        facts, here = member.facts(), problem.where(index)
        fold = fold_of(facts.tile % TILES_OF_A_FRAME)
        medians.append(_medians(facts, fold, [shift[here] for shift in shifts]))
    return tuple(medians)


def by_recording(members: Sequence[Member], own: int, recording: Int[np.ndarray, "f"]) -> tuple[Medians, ...]:
    """Each tile under shared parameters that saw nothing of its recording, nor its ranges, and own ones that did not
    see its place.

    Args:
        recording: of each frame, where there is one member: its frames are then divided, and share all parameters.
    """
    problem = joint(members, own)
    if len(members) == 1:
        facts, part = members[0].facts(), problem.parts[0]
        shifts = [problem.shift(lambda _, part, r=r: recording[part.frame] != r) for r in range(recording.max() + 1)]
        return (_medians(facts, recording[facts.tile // TILES_OF_A_FRAME], shifts),)
    medians = []
    for index, (member, part) in enumerate(zip(members, problem.parts, strict=True)):
        rest = problem.without_ranges(index)
        others = rest.shift(lambda m, part, r=index: np.full(len(part.place), m != r))[problem.where(index)]
        facts, folds = member.facts(), fold_of(part.place)
        shifts = [_own_shift(problem, part.of(folds != fold), member.z, others, own) for fold in range(FOLDS)]
        medians.append(_medians(facts, fold_of(facts.tile % TILES_OF_A_FRAME), shifts))
    return tuple(medians)


def _own_shift(
    problem: Joint,
    part: Sums,
    z: Float[np.ndarray, "n"],
    shift: Float[np.ndarray, "n"],
    own: int,
) -> Float[np.ndarray, "n"]:
    """The shift of own parameters that some tiles ask for, with that of the shared ones as it is."""
    normal, prior = part.normal.sum(0), np.eye(own) / problem.prior**2
    pull = part.pull.sum(0)[:own] + normal[:own, own:] @ shift[own:] + prior @ z[:own]
    return np.concatenate([-np.linalg.solve(normal[:own, :own] + prior, pull), shift[own:]])


def _medians(
    facts: Evidence, fold: Int[np.ndarray, "m"], shifts: Sequence[Float[np.ndarray, "n"]]
) -> Float[np.ndarray, "t"]:
    unseen = np.empty_like(facts.residual)
    for number, shift in enumerate(shifts):
        here = fold == number
        unseen[here] = facts.residual[here] + facts.jacobian[here] @ shift
    return facts.medians(unseen)
