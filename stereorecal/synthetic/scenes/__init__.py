"""The kinds of scenes: one module for each, which holds its maker; every module in this folder is a kind.

To add a kind, write a module here with a function that takes a random generator and returns a `World`, and append it
to `MAKERS`. Draw everything from that generator, so that a seed gives the same images again. Things that several kinds
can show belong to `objects`, ground and sky to `surroundings`, the motion of the rig to `world`.
"""

import difflib
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from stereorecal import InputError
from stereorecal.synthetic.scenes._coast import coast
from stereorecal.synthetic.scenes._harbour import harbour
from stereorecal.synthetic.scenes._open_sea import open_sea
from stereorecal.synthetic.scenes._street import street
from stereorecal.synthetic.world._world import World

# The position of a kind is part of its seed: append, so that the other kinds keep their images.
MAKERS: dict[str, Callable[[np.random.Generator], World]] = {
    "harbour": harbour,
    "coast": coast,
    "open-sea": open_sea,
    "street": street,
}
"""Name of each kind and what makes a world of it."""

KINDS = tuple(MAKERS)


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
