"""The estimate of a rig: all its parameters, the prior of what its calibration left, a drift, and rows, in one least
squares; `docs/estimate.md` explains it.

`_rig_parameters` names θ; `_calibration_prior` is its prior, a drift included, `_prior_choice` what users may choose
instead, and what the next call begins with. `_groups` has the rows as data, `_linear_groups` their misfit,
`_matched_ranges` measured ranges, `_motion` the rig's own motion (`_motion_residuals`: what tracks should do),
`_confounders` (`_outlines`: of regions) and `_late_shutter` what else may be behind rows. `_evidence` integrates in
closed form, `_explanations` compares, `_least_squares` solves one recording or several of one rig; `_mixture` is the
answer, `_consequences` what errors of a rig do to rows and depth, `_losses` what they cost, and the rigs that may be
written.
"""

from stereorecal.estimation._calibration_prior import (
    calibration_covariances as calibration_covariances,
    calibration_prior as calibration_prior,
    physical_prior as physical_prior,
    with_scaled_boards as with_scaled_boards,
)
from stereorecal.estimation._consequences import (
    Consequences as Consequences,
    consequences as consequences,
    nearness_of as nearness_of,
    points_of_view as points_of_view,
    readings as readings,
)
from stereorecal.estimation._estimate import (
    DISTANCES as DISTANCES,
    Estimate as Estimate,
    HeldOut as HeldOut,
    with_free_together as with_free_together,
)
from stereorecal.estimation._evidence import Normal as Normal
from stereorecal.estimation._explanations import NEGLIGIBLE as NEGLIGIBLE
from stereorecal.estimation._groups import FEWEST_GROUPS as FEWEST_GROUPS, PLACES as PLACES, grouped as grouped
from stereorecal.estimation._least_squares import (
    Fit as Fit,
    Recording as Recording,
    agreement as agreement,
    beside_others as beside_others,
    estimate as estimate,
    fitted as fitted,
    fitted_together as fitted_together,
    most_probable as most_probable,
)
from stereorecal.estimation._linear_groups import normal_of_pair as normal_of_pair, rows_of_groups as rows_of_groups
from stereorecal.estimation._losses import (
    Losses as Losses,
    Matters as Matters,
    extrinsics_like as extrinsics_like,
    points_shown as points_shown,
)
from stereorecal.estimation._matched_ranges import NO_RANGES as NO_RANGES, MatchedRanges as MatchedRanges
from stereorecal.estimation._mixture import (
    Mixture as Mixture,
    median_and_interval as median_and_interval,
    root as root,
)
from stereorecal.estimation._motion import (
    NO_WINDOWS as NO_WINDOWS,
    Windows as Windows,
    far_enough as far_enough,
    window as window,
)
from stereorecal.estimation._one_thread import one_blas_thread as one_blas_thread
from stereorecal.estimation._prior_choice import (
    DEFAULT as DEFAULT,
    EXACT as EXACT,
    SAVED as SAVED,
    CalibrationCovariance as CalibrationCovariance,
    Prior as Prior,
    SavedPrior as SavedPrior,
    as_prior as as_prior,
    check_prior as check_prior,
    is_exact as is_exact,
    recentred_posterior as recentred_posterior,
    updated as updated,
    with_deviations as with_deviations,
)
from stereorecal.estimation._rig_parameters import (
    pixels_of as pixels_of,
    rig_parameters as rig_parameters,
    slopes_by_point as slopes_by_point,
    slopes_of as slopes_of,
)
