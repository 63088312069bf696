"""The kinds of scenes: one module for each, which holds its maker; every module in this folder is a kind.

To add a kind, write a module here with a function that takes a random generator and returns a `World`, and append it
to `MAKERS`. Draw everything from that generator, so that a seed gives the same images again. Things that several kinds
can show belong to `objects`, ground and sky to `surroundings`, the motion of the rig to `world`.
"""

from collections.abc import Callable

import numpy as np

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
