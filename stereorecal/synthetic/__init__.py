"""Synthetic stereo scenes of a known rig, their ground truth, random drift, and drives."""

from stereorecal.synthetic._drive import (
    Drive as Drive,
    Knock as Knock,
    photographs as photographs,
    plan_drive as plan_drive,
)
from stereorecal.synthetic._ground_truth import (
    GroundTruth as GroundTruth,
    ground_truth as ground_truth,
    ranges as ranges,
)
from stereorecal.synthetic._render import decalibrate as decalibrate, default_rig as default_rig, render as render
from stereorecal.synthetic._scenes import KINDS as KINDS
