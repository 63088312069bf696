"""What an epipolar error costs the matchers that people use, as measured on Middlebury's motorcycle with shifted rows
(tests/benchmarks/matcher_loss.py)."""

import numpy as np

_NETWORKS = 2.0  # pixels: stereo networks ask for less (S2M2; Min et al. 2025)
_AT = (0.5, 0.75, 1.0, 1.5, 2.0)  # pixels; below, block matching finds as much, and as much of what SGM finds is right
_LOST = (0.0, 4.0, 11.0, 30.0, 45.0)  # percent of the pixels of StereoBM
_WRONG = (0.0, 1.0, 3.0, 9.0, 18.0)  # percent of the pixels of StereoSGBM that are off by more than 2 px


def matcher_loss(px: float) -> str:
    """What a mean epipolar error, in pixels, costs block matching, semi-global matching and networks."""
    if px <= _AT[0]:
        return f"less than {_AT[0]:g} px hardly costs a matcher pixels"
    if px > _NETWORKS:
        return f"by {px:.2f} px block matching loses most of its pixels; networks ask for less than {_NETWORKS:g} px"
    lost, wrong = (float(np.interp(px, _AT, values)) for values in (_LOST, _WRONG))
    return (
        f"block matching loses about {lost:.0f} % of its pixels by {px:.2f} px; {wrong:.0f} % of those of SGM go wrong"
    )
