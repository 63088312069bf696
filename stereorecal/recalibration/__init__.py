"""Recalibration: schedules, the repair itself, uncertainty, the verdict."""

from stereorecal.decision import Reason as Reason, is_sparse as is_sparse
from stereorecal.recalibration._case import MOST_FRAMES as MOST_FRAMES, Case as Case, chosen_frames as chosen_frames
from stereorecal.recalibration._difference import (
    DISTANCES as DISTANCES,
    ROW_DISTANCES as ROW_DISTANCES,
    Difference as Difference,
    depth_error as depth_error,
    depth_errors as depth_errors,
    difference as difference,
    row_errors_of as row_errors_of,
)
from stereorecal.recalibration._expected import (
    DepthError as DepthError,
    Interval as Interval,
    as_distances as as_distances,
)
from stereorecal.recalibration._many import (
    Fault as Fault,
    Repair as Repair,
    recalibrate_many as recalibrate_many,
)
from stereorecal.recalibration._match_ranges import RangesSeen as RangesSeen
from stereorecal.recalibration._mismatch import Cause as Cause, Mismatch as Mismatch, fixed as fixed
from stereorecal.recalibration._prior_use import PriorUse as PriorUse, saved_with as saved_with
from stereorecal.recalibration._recalibrate import (
    HEALTH_LIMITS as HEALTH_LIMITS,
    health as health,
    recalibrate as recalibrate,
    recalibrate_case as recalibrate_case,
    what_may_change as what_may_change,
)
from stereorecal.recalibration._result import Condition as Condition
from stereorecal.recalibration._row_residuals import (
    RowErrors as RowErrors,
    places_of as places_of,
    tile_medians as tile_medians,
)
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
    settings_as_data as settings_as_data,
)
from stereorecal.recalibration._solution import Solution as Solution
from stereorecal.recalibration._stages import Cost as Cost, Waypoint as Waypoint
from stereorecal.recalibration._uncertainty import (
    NORMAL_95 as NORMAL_95,
    Intrinsics as Intrinsics,
    IntrinsicsOutcome as IntrinsicsOutcome,
    Uncertainty as Uncertainty,
)
