"""Names of the parameters of a rig that may be free, and of groups of them."""

ROTATION = ("pitch", "yaw", "roll")
EXTRINSICS = (*ROTATION, "y", "z")  # x stays: the length of the baseline only scales depth (paper, section 3.3)
BASELINE = "baseline"
SIDES = ("left", "right")

_DEFAULT_LENS = ("f", "cx", "cy", "k1", "k2")
_OPTIONAL_LENS = ("aspect", "p1", "p2", "k3", "s1", "s2", "s3", "s4", "k4", "xi", "alpha", "beta")
INTRINSICS = tuple(f"{side}.{name}" for side in SIDES for name in _DEFAULT_LENS)
GROUPS = {"rotation": ROTATION, "extrinsics": EXTRINSICS, "intrinsics": INTRINSICS}
NAMES = (*EXTRINSICS, BASELINE, *(f"{side}.{name}" for side in SIDES for name in (*_DEFAULT_LENS, *_OPTIONAL_LENS)))
