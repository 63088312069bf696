"""Which prior a repair begins with, which of its pairs count, and what is known after it."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.estimation import (
    DEFAULT,
    EXACT,
    SAVED,
    CalibrationCovariance,
    Estimate,
    Prior,
    SavedPrior,
    as_prior,
    check_prior,
    is_exact,
    recentred_posterior,
    rig_parameters,
    with_deviations,
    with_scaled_boards,
)
from stereorecal.geometry import StereoRig
from stereorecal.objectives import BASELINE, EXTRINSICS, Parameters, Reach
from stereorecal.recordings import Pair


@dataclass(frozen=True, eq=False)
class PriorUse:
    """What a repair began with, or a look.

    Attributes:
        name: "default", "saved" (with the calibration), "saved, without these pairs" (all of which were used already:
            what was known before them), "exact", or "given".
        prior: that the estimate computes with.
        images: fingerprints of all pairs.
        numbers: of the pairs that count.
        note: what else is to be said, or None.
        other_images: fingerprints of the pairs of other recordings that the same estimate rests on.
        saved: the saved prior that was given, which stays where nothing is learnt.
    """

    name: str
    prior: Prior
    images: tuple[str, ...]
    numbers: tuple[int, ...]
    note: str | None = None
    other_images: tuple[str, ...] = ()
    saved: SavedPrior | None = None

    @property
    def dropped(self) -> int:
        """How many pairs do not count again."""
        return len(self.images) - len(self.numbers)

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {"name": self.name, "pairs_that_count": len(self.numbers), "not_again": self.dropped, "note": self.note}

    def __str__(self) -> str:
        parts = [self.name]
        if self.dropped:
            one = self.dropped == 1
            parts.append(
                f"{self.dropped} of {len(self.images)} pairs {'was' if one else 'were'} used before and "
                f"{'does' if one else 'do'} not count again"
            )
        return "; ".join([*parts, *([self.note] if self.note else [])])


def prior_use(prior: Prior, rig: StereoRig, pairs: Sequence[Pair], *, learns: bool = True) -> PriorUse:
    """What a repair begins with, or a look.

    Args:
        prior: as `recalibrate` takes it.
        learns: whether a prior is to follow; else all pairs count, also those that a saved one rests on.

    Raises:
        InputError: if the prior makes no sense, or belongs to another rig; if it is to be the saved one and there is
            none; or if all pairs were used already, by other repairs than the last one.
    """
    check_prior(prior, rig_parameters(rig))
    images = tuple(map(fingerprint, pairs))
    every, note = tuple(range(len(images))), None
    if is_exact(prior):
        return PriorUse(EXACT, EXACT, images, every)
    if prior is None or (isinstance(prior, str) and prior == SAVED):
        found, note = saved_with(rig)
        if found is None and prior == SAVED:
            raise InputError(note or "no prior is saved with this calibration; leave prior= (--prior) out.")
        prior = found or DEFAULT
    if isinstance(prior, SavedPrior):
        return _without_used_images(prior, images) if learns else PriorUse(SAVED, prior, images, every, saved=prior)
    return PriorUse(DEFAULT if prior == DEFAULT else "given", prior, images, every, note=note)


def _without_used_images(saved: SavedPrior, images: tuple[str, ...]) -> PriorUse:
    """Pairs that a prior rests on do not count; where it rests on all of them, what was known before stands in."""
    numbers = _fresh(images, saved.images)
    if numbers or not images:
        return PriorUse(SAVED, saved, images, numbers, saved=saved)
    before = saved.earlier and saved.earlier.counted_from(saved.rig)
    numbers = () if before is None else _fresh(images, before.images)
    if not numbers:
        raise InputError("all of these pairs were used by earlier repairs of this rig; give others.")
    return PriorUse("saved, without these pairs", before, images, numbers, saved=saved)


def _fresh(images: Sequence[str], used: Sequence[str]) -> tuple[int, ...]:
    return tuple(number for number, image in enumerate(images) if image not in set(used))


def known_after(
    use: PriorUse, estimated: Estimate | None, initial: StereoRig, rig: StereoRig, used: Sequence[str], *, good: bool
) -> SavedPrior | None:
    """What is known of the rig to use; None: no more than of any calibration.

    Args:
        estimated: None where nothing was found.
        used: fingerprints of the pairs that it rests on.
        good: whether the rig to use is good; else the images do not fit any rig, and nothing is learnt from them.
    """
    saved = use.prior if isinstance(use.prior, SavedPrior) else None
    rows_alone = estimated is None or is_exact(use.prior)
    if not good or (rows_alone and rig is initial):
        return use.saved
    if estimated is None or rows_alone:
        return SavedPrior(rig, None)
    default = use.prior is None or isinstance(use.prior, str)
    before = saved or SavedPrior(initial, DEFAULT if default else as_prior(use.prior, rig_parameters(initial)))
    images = (*before.images, *used, *use.other_images)
    known = recentred_posterior(estimated.posterior, estimated.chart.coordinates_of(rig))
    return SavedPrior(rig, known, tuple(dict.fromkeys(images)), replace(before, earlier=None))


def saved_with(rig: StereoRig) -> tuple[SavedPrior | None, str | None]:
    """What was saved with a calibration that was read from a file, and if it is not used, why.

    Raises:
        InputError: naming the file, if it cannot be read, or is something else.
    """
    stored = getattr(rig.source, "prior", None)  # of the file that it came from
    if stored is None:
        return None, None
    saved = stored.read(SavedPrior.from_dict)
    if stored.of(rig):
        return saved, None
    return None, f"{stored.place} is of other parameters than this calibration has now, and is not used"


def fingerprint(pair: Pair) -> str:
    """A digest of the grey levels of both images: the same for the same pixels, whatever the names."""
    digest = hashlib.blake2b(repr(pair.size).encode(), digest_size=8)
    for image in (pair.left, pair.right):
        digest.update(np.ascontiguousarray(image, np.float32).data)
    return digest.hexdigest()


def prior_of(prior: Prior, free: Parameters, rig: StereoRig, reach: Reach, *, ranges: bool) -> Prior:
    """What is known of the calibration: the prior, with what `free` says of single parameters. Where all is exact, what
    is free and no drift moves is as uncertain as `free` has it. With ranges, where nobody says how long the baseline
    is, it may be as wrong as the sizes of boards are: what was learnt without ranges does not tell."""
    sigmas = {name: sigma for name, sigma in free.priors.items() if name not in EXTRINSICS}
    if exact := is_exact(prior):
        sigmas = {one.name: one.sigma for one in free.of(rig, reach) if one.name in free.shared}
    named = prior.names if isinstance(prior, CalibrationCovariance) else prior if isinstance(prior, Mapping) else ()
    widens = ranges and not exact and BASELINE not in (*sigmas, *named)
    if not sigmas and not widens:
        return prior
    chart = rig_parameters(rig)
    known = as_prior(prior, chart)
    return with_deviations(with_scaled_boards(known, chart) if widens else known, chart, sigmas)


def load_prior(path: str | Path | Sequence[str | Path]) -> SavedPrior | None:
    """What was saved with a calibration, as `sr.io.load_rig` finds it; None if nothing was.

    `recalibrate` looks it up by itself, for a rig that `sr.io.load_rig` has read.

    Args:
        path: of the calibration: a file, two, or a folder that holds one.

    Raises:
        InputError: naming the file, if it cannot be read, or belongs to other parameters than are in the calibration.
    """
    from stereorecal.io import load_rig  # what repairs a rig in memory reads no files

    saved, note = saved_with(load_rig(path))
    if note is not None:
        raise InputError(f"{note}; recalibrate again.")
    return saved
