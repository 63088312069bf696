"""Steps of θ that stay where the lenses of the rig have rays for what was seen.

Wide lenses end: where the terms of one move far, its image may fold back before a pixel that showed something.
"""

import numpy as np
from jaxtyping import Float

from stereorecal.objectives import RigChart
from stereorecal.scoring import Correspondences, with_rays_of

_HALVINGS = 20


def within_field(
    found: Correspondences, chart: RigChart, theta: Float[np.ndarray, "n"], move: Float[np.ndarray, "n"]
) -> Float[np.ndarray, "n"]:
    """The move from θ, halved until the lenses there have rays for all that was found; 0 if none does. Lenses that are
    not wide have no such end."""
    if not chart.rig.is_wide:
        return move
    for _ in range(_HALVINGS):
        if chart.stands_at(theta + move) and _has_rays(found, chart, theta + move):
            return move
        move = 0.5 * move
    return np.zeros_like(move)


def _has_rays(found: Correspondences, chart: RigChart, theta: Float[np.ndarray, "n"]) -> bool:
    read = with_rays_of(chart.rig_at(theta), found, matched_rig=chart.rig)
    counts = np.asarray(found.weight) > 0
    return all(bool(np.isfinite(np.asarray(rays)[counts]).all()) for rays in (read.left, read.right))
