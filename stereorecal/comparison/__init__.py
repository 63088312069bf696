"""Comparisons: strategies x draws x scenes."""

from stereorecal.comparison._compare import (
    ComparisonOptions as ComparisonOptions,
    Drift as Drift,
    compare as compare,
    compare_scenes as compare_scenes,
)
from stereorecal.comparison._comparison import Comparison as Comparison
from stereorecal.comparison._entrants import load_strategies as load_strategies
from stereorecal.comparison._summary import summarise as summarise
from stereorecal.comparison._trial import (
    DISTANCES as DISTANCES,
    FAILED as FAILED,
    THRESHOLDS as THRESHOLDS,
    Trial as Trial,
    errors_by_truth as errors_by_truth,
    is_harmful as is_harmful,
)
