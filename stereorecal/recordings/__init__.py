"""Data as users have them: pairs, scenes, missions, logs, ranges; and the checks of pairs."""

from stereorecal.recordings._as_pairs import (
    Images as Images,
    Pairs as Pairs,
    as_pairs as as_pairs,
    check_pairs as check_pairs,
    check_two_images as check_two_images,
)
from stereorecal.recordings._distances import LONGEST_GAP as LONGEST_GAP, Odometer as Odometer, Range as Range
from stereorecal.recordings._lazy_pairs import (
    LazyPairs as LazyPairs,
    PairSequence as PairSequence,
    names_of as names_of,
    picked as picked,
    times_of as times_of,
)
from stereorecal.recordings._pair import Pair as Pair, make_pair as make_pair, share_of as share_of
from stereorecal.recordings._scenes import Log as Log, Mission as Mission, Scene as Scene
