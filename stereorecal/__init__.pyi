"""All public names; `__init__.py` imports each when it is first used."""

from . import (
    comparison as comparison,
    estimation as estimation,
    geometry as geometry,
    io as io,
    matching as matching,
    objectives as objectives,
    online as online,
    recalibration as recalibration,
    recordings as recordings,
    scoring as scoring,
    synthetic as synthetic,
    testing as testing,
)
from ._errors import (
    CalibrationWarning as CalibrationWarning,
    InputError as InputError,
    MatcherError as MatcherError,
    PairingWarning as PairingWarning,
    StrategyError as StrategyError,
    UnsupportedModelError as UnsupportedModelError,
)
from ._version import __version__ as __version__
from .comparison import (
    Comparison as Comparison,
    ComparisonOptions as ComparisonOptions,
    Drift as Drift,
    compare as compare,
    compare_scenes as compare_scenes,
)
from .decision import Tolerances as Tolerances
from .estimation import (
    CalibrationCovariance as CalibrationCovariance,
    Estimate as Estimate,
    SavedPrior as SavedPrior,
)
from .geometry import (
    Camera as Camera,
    Rectification as Rectification,
    StereoRig as StereoRig,
    View as View,
    rectification as rectification,
    view as view,
)
from .matching import (
    BM as BM,
    SAD as SAD,
    SGBM as SGBM,
    Disparity as Disparity,
    matcher as matcher,
    matchers as matchers,
)
from .objectives import Parameters as Parameters, Reach as Reach, objective as objective
from .recalibration import (
    Cost as Cost,
    Difference as Difference,
    HealthOptions as HealthOptions,
    Intrinsics as Intrinsics,
    IntrinsicsOutcome as IntrinsicsOutcome,
    Reason as Reason,
    Repair as Repair,
    RepairOptions as RepairOptions,
    Schedule as Schedule,
    Solution as Solution,
    difference as difference,
    health as health,
    recalibrate as recalibrate,
    recalibrate_many as recalibrate_many,
)
from .recalibration._prior_use import load_prior as load_prior
from .recordings import (
    Log as Log,
    Mission as Mission,
    Odometer as Odometer,
    Pair as Pair,
    Range as Range,
    Scene as Scene,
    make_pair as make_pair,
)
from .scoring import (
    Correspondences as Correspondences,
    ScoringData as ScoringData,
    correspondences as correspondences,
    count as count,
    prepare as prepare,
    row_differences as row_differences,
    soft_count as soft_count,
)
from .scoring.host import (
    Score as Score,
    disparity as disparity,
    rectify as rectify,
    score as score,
    with_disparity_range as with_disparity_range,
)
from .strategies import Budget as Budget, Status as Status, strategies as strategies, strategy as strategy
