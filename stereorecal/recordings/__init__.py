"""Data as users have them: pairs, scenes, missions, logs, ranges; and the checks of pairs."""

from stereorecal.recordings._as_pairs import Images as Images, Pairs as Pairs, as_pairs as as_pairs
from stereorecal.recordings._check_pairs import check_pairs as check_pairs, check_two_images as check_two_images
from stereorecal.recordings._lazy_pairs import (
    LazyPairs as LazyPairs,
    PairSequence as PairSequence,
    names_of as names_of,
    picked as picked,
    times_of as times_of,
)
from stereorecal.recordings._log import Log as Log, Mission as Mission
from stereorecal.recordings._odometer import LONGEST_GAP as LONGEST_GAP, Odometer as Odometer
from stereorecal.recordings._pair import Pair as Pair, make_pair as make_pair
from stereorecal.recordings._range import Range as Range
from stereorecal.recordings._readout import share_of as share_of
from stereorecal.recordings._scene import Scene as Scene
