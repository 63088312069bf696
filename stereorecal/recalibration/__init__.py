"""Recalibration: schedules, the repair itself, uncertainty, the verdict."""

from stereorecal.decision import Reason as Reason
from stereorecal.recalibration._case import Case as Case
from stereorecal.recalibration._cost import Cost as Cost
from stereorecal.recalibration._depth_errors import DepthError as DepthError, as_distances as as_distances
from stereorecal.recalibration._difference import Difference as Difference, difference as difference
from stereorecal.recalibration._expected import Interval as Interval
from stereorecal.recalibration._frame_choice import MOST_FRAMES as MOST_FRAMES, chosen_frames as chosen_frames
from stereorecal.recalibration._freed_intrinsics import Intrinsics as Intrinsics, IntrinsicsOutcome as IntrinsicsOutcome
from stereorecal.recalibration._health import HEALTH_LIMITS as HEALTH_LIMITS, health as health
from stereorecal.recalibration._many import (
    Fault as Fault,
    Repair as Repair,
    recalibrate_many as recalibrate_many,
    sharing as sharing,
)
from stereorecal.recalibration._match_ranges import RangesSeen as RangesSeen
from stereorecal.recalibration._mismatch import Cause as Cause, Mismatch as Mismatch, fixed as fixed
from stereorecal.recalibration._prepared_case import what_may_change as what_may_change
from stereorecal.recalibration._prior_use import (
    PriorUse as PriorUse,
    saved_with as saved_with,
)
from stereorecal.recalibration._recalibrate import (
    recalibrate as recalibrate,
    recalibrate_case as recalibrate_case,
)
from stereorecal.recalibration._result import Condition as Condition
from stereorecal.recalibration._rig_errors import (
    DISTANCES as DISTANCES,
    ROW_DISTANCES as ROW_DISTANCES,
    depth_error as depth_error,
    depth_errors as depth_errors,
    row_errors_of as row_errors_of,
)
from stereorecal.recalibration._row_residuals import RowErrors as RowErrors, RowResiduals as RowResiduals
from stereorecal.recalibration._schedule import (
    SCHEDULES as SCHEDULES,
    Schedule as Schedule,
    ScoreKind as ScoreKind,
    Stage as Stage,
    watching_scale as watching_scale,
)
from stereorecal.recalibration._search import Progress as Progress, next_slice as next_slice
from stereorecal.recalibration._settings import (
    HealthOptions as HealthOptions,
    RepairOptions as RepairOptions,
    Settings as Settings,
    as_settings as as_settings,
)
from stereorecal.recalibration._solution import Solution as Solution
from stereorecal.recalibration._stages import Waypoint as Waypoint
from stereorecal.recalibration._uncertainty import NORMAL_95 as NORMAL_95, Uncertainty as Uncertainty
from stereorecal.recalibration._unmatched import is_sparse as is_sparse
