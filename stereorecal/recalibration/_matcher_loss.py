"""What an epipolar error costs the matchers that people use, as measured on Middlebury's motorcycle with shifted rows
(tests/benchmarks/matcher_loss.py)."""

import numpy as np
from jaxtyping import Float

_NETWORKS = 2.0  # pixels: stereo networks ask for less (S2M2; Min et al. 2025)
_AT = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # pixels; below, block matching finds as much, and SGM as much that is right
_LOST = (0.0, 4.0, 11.0, 30.0, 45.0, 59.0)  # percent of the pixels of StereoBM
_WRONG = (0.0, 1.0, 3.0, 9.0, 18.0, 37.0)  # percent of the pixels of StereoSGBM that are off by more than 2 px


def matcher_loss(rows: Float[np.ndarray, "p"], weights: Float[np.ndarray, "p"]) -> str:
    """What epipolar errors cost block matching, semi-global matching and networks.

    Args:
        rows: of points that stand for what the images show, pixels at full size.
        weights: of the points; they sum to 1.
    """
    lost, wrong = (float(weights @ np.interp(np.abs(rows), _AT, values)) for values in (_LOST, _WRONG))
    if lost < 1.0:
        return "hardly a pixel lost"
    if weights @ np.abs(rows) > _AT[-1]:
        return f"block matching loses most of its pixels; networks ask for less than {_NETWORKS:g} px"
    text = f"block matching loses about {lost:.0f} % of its pixels, {wrong:.0f} % of those of SGM go wrong"
    return text if weights @ np.abs(rows) < _NETWORKS else f"{text}; networks ask for less than {_NETWORKS:g} px"
