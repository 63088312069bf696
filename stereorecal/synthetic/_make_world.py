"""A world to be rendered, by its kind and a seed."""

import difflib
from functools import lru_cache

import numpy as np

from stereorecal import InputError
from stereorecal.synthetic.scenes import KINDS, MAKERS
from stereorecal.synthetic.world._world import World


@lru_cache(maxsize=4)
def make_world(kind: str, seed: int) -> World:
    """The world of a kind drawn from `seed`; the last four are cached, since render and ground truth share them.

    Raises:
        InputError: for an unknown kind or a negative seed.
    """
    if kind not in MAKERS:
        close = difflib.get_close_matches(str(kind), KINDS, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else "."
        raise InputError(f"unknown kind of scene {kind!r}: it must be one of {', '.join(KINDS)}{hint}")
    if seed < 0:
        raise InputError(f"the seed is {seed}; give a whole number that is not negative.")
    return MAKERS[kind](np.random.default_rng([KINDS.index(kind), seed]))
