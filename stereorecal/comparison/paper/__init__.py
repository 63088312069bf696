"""The paper's five experiments (section 4)."""

from stereorecal.comparison.paper._experiments import (
    EXPERIMENTS as EXPERIMENTS,
    QUICK as QUICK,
    Extent as Extent,
    methods as methods,
)
from stereorecal.comparison.paper._files import write_files as write_files
from stereorecal.comparison.paper._reproduce import Reproduction as Reproduction, reproduce as reproduce
from stereorecal.comparison.paper._synthetic_log import synthetic_log as synthetic_log
