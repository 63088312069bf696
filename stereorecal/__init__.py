"""stereorecal: repair the extrinsic calibration of a stereo rig from ordinary images."""

from stereorecal import geometry as geometry, io as io, synthetic as synthetic, testing as testing
from stereorecal._errors import (
    InputError as InputError,
    StrategyError as StrategyError,
    UnsupportedModelError as UnsupportedModelError,
)
from stereorecal.comparison import (
    Comparison as Comparison,
    Drift as Drift,
    compare as compare,
    compare_scenes as compare_scenes,
)
from stereorecal.geometry import Camera as Camera, StereoRig as StereoRig, View as View, view as view
from stereorecal.matching import BM as BM, SAD as SAD, SGBM as SGBM, Disparity as Disparity
from stereorecal.objectives import Reach as Reach, objective as objective
from stereorecal.recalibration import (
    Cost as Cost,
    Health as Health,
    Reason as Reason,
    Repair as Repair,
    Schedule as Schedule,
    Solution as Solution,
    health as health,
    recalibrate as recalibrate,
    recalibrate_many as recalibrate_many,
    recalibrate_sequence as recalibrate_sequence,
)
from stereorecal.recordings import Log as Log, Mission as Mission, Pair as Pair, Scene as Scene, make_pair as make_pair
from stereorecal.reproduction import (
    Extent as Extent,
    Reproduction as Reproduction,
    reproduce as reproduce,
    synthetic_log as synthetic_log,
)
from stereorecal.scoring import (
    Correspondences as Correspondences,
    Score as Score,
    ScoringData as ScoringData,
    correspondences as correspondences,
    count as count,
    disparity as disparity,
    prepare as prepare,
    rectify as rectify,
    row_differences as row_differences,
    score as score,
    soft_count as soft_count,
    with_disparity_range as with_disparity_range,
)
from stereorecal.strategies import Budget as Budget, Status as Status, strategies as strategies, strategy as strategy
