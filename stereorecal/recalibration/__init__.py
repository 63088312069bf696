"""Recalibration: schedules, the repair itself, uncertainty, the verdict."""

from stereorecal.recalibration._acceptance import (
    FEWEST_PLACES as FEWEST_PLACES,
    LEAST_COVERED as LEAST_COVERED,
    ROWS_MATTER as ROWS_MATTER,
    Reason as Reason,
    RowErrors as RowErrors,
)
from stereorecal.recalibration._consequences import Interval as Interval, depth_intervals as depth_intervals
from stereorecal.recalibration._cost import Cost as Cost
from stereorecal.recalibration._difference import Difference as Difference, difference as difference
from stereorecal.recalibration._evidence import Evidence as Evidence, evidence as evidence
from stereorecal.recalibration._health import (
    HEALTH_LIMITS as HEALTH_LIMITS,
    Condition as Condition,
    Health as Health,
    health as health,
)
from stereorecal.recalibration._intrinsics import Intrinsics as Intrinsics, IntrinsicsOutcome as IntrinsicsOutcome
from stereorecal.recalibration._look import solved as solved
from stereorecal.recalibration._many import (
    Fault as Fault,
    Repair as Repair,
    looked_at as looked_at,
    recalibrate_many as recalibrate_many,
    repaired_together as repaired_together,
    repairs_as_finished as repairs_as_finished,
    sharing as sharing,
)
from stereorecal.recalibration._path import Waypoint as Waypoint
from stereorecal.recalibration._ranges import with_ranges as with_ranges
from stereorecal.recalibration._recalibrate import recalibrate as recalibrate
from stereorecal.recalibration._rescale import Rescaled as Rescaled, rescale_baseline as rescale_baseline
from stereorecal.recalibration._schedule import (
    SCHEDULES as SCHEDULES,
    Schedule as Schedule,
    ScoreKind as ScoreKind,
    Stage as Stage,
    as_schedule as as_schedule,
    watching_scale as watching_scale,
)
from stereorecal.recalibration._sequence import recalibrate_sequence as recalibrate_sequence
from stereorecal.recalibration._solution import Solution as Solution
from stereorecal.recalibration._stages import FEWEST as FEWEST
from stereorecal.recalibration._uncertainty import Uncertainty as Uncertainty
from stereorecal.recalibration._warm_up import warm_up as warm_up
