"""Comparisons: strategies x draws x scenes."""

from stereorecal.comparison._compare import (
    ComparisonOptions as ComparisonOptions,
    Drift as Drift,
    compare as compare,
    compare_scenes as compare_scenes,
)
from stereorecal.comparison._comparison import Comparison as Comparison
from stereorecal.comparison._entrants import load_strategies as load_strategies
from stereorecal.comparison._summary import Summary as Summary, Thresholds as Thresholds, summarise as summarise
from stereorecal.comparison._trial import (
    DISTANCES as DISTANCES,
    FAILED as FAILED,
    Trial as Trial,
    errors_by_truth as errors_by_truth,
    is_harmful as is_harmful,
)
