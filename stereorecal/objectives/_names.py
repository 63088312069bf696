"""Names of the parameters of a rig that may be free."""

ROTATION = ("pitch", "yaw", "roll")
EXTRINSICS = (*ROTATION, "y", "z")  # x stays: the length of the baseline only scales depth (paper, section 3.3)
BASELINE = "baseline"
SIDES = ("left", "right")
