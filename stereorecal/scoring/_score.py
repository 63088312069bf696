"""What a user asks of one calibration: its score, its rectified images, its disparity."""

from collections.abc import Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig, View, view as default_view
from stereorecal.matching import SAD, AbstractMatcher, Disparity
from stereorecal.recordings import Pair
from stereorecal.scoring._count import counts_one_by_one, disparities
from stereorecal.scoring._prepare import normalised, prepare, rectified_frame
from stereorecal.scoring._survey import with_disparity_range


@dataclass(frozen=True)
class Score:
    """A count with what it is out of.

    Attributes:
        count: pixels with a valid disparity, over all frames.
        pixels: pixels of the view, over all frames.
    """

    count: int
    pixels: int

    @property
    def fraction(self) -> float:
        """Share of the pixels that are valid."""
        return self.count / self.pixels

    def __str__(self) -> str:
        return f"{_spaced(self.count)} of {_spaced(self.pixels)} pixels ({100 * self.fraction:.1f} %)"


def _spaced(number: int) -> str:
    return f"{number:,}".replace(",", " ")


def score(
    rig: StereoRig,
    pairs: Sequence[Pair],
    *,
    matcher: AbstractMatcher | None = None,
    view: View | None = None,
    scale: float = 1.0,
) -> Score:
    """How many pixels of the pairs find a valid disparity under the rig's calibration.

    Args:
        matcher: default `SAD()`; without `num_disparities` the range is measured.
        view: default the view of `rig`. Scores are comparable only within one view and one disparity range: to
            compare calibrations, give both (a `Solution` carries its own).
        scale: image scale, (0, 1].

    Raises:
        InputError: if images and calibration do not fit.
    """
    view = default_view(rig) if view is None else view
    matcher = with_disparity_range(matcher or SAD(), rig, pairs, view)
    data = prepare(rig, pairs, view, scale)
    found = counts_one_by_one(data, normalised(rig.extrinsics)[None], matcher.scaled(scale))
    return Score(int(found[0]), data.pixels)


def rectify(
    rig: StereoRig, pair: Pair, *, view: View | None = None
) -> tuple[Float[np.ndarray, "h w"], Float[np.ndarray, "h w"]]:
    """Left and right image rectified, float32 in the view (default: the rig's own); borders are repeated."""
    frame = rectified_frame(
        prepare(rig, [pair], default_view(rig) if view is None else view),
        jnp.asarray(normalised(rig.extrinsics), jnp.float32),
    )
    return np.asarray(frame.left), np.asarray(frame.right)


def disparity(
    rig: StereoRig, pair: Pair, *, matcher: AbstractMatcher | None = None, view: View | None = None
) -> Disparity:
    """The disparity of one pair, NumPy arrays; `valid` is what `score` counts with the same view and matcher."""
    view = default_view(rig) if view is None else view
    matcher = with_disparity_range(matcher or SAD(), rig, [pair], view)
    return disparities(prepare(rig, [pair], view), normalised(rig.extrinsics), matcher)[0]
