"""The paper's five experiments (section 4)."""

from stereorecal.reproduction._experiments import (
    EXPERIMENTS as EXPERIMENTS,
    QUICK as QUICK,
    Extent as Extent,
    methods as methods,
)
from stereorecal.reproduction._reproduce import Reproduction as Reproduction, reproduce as reproduce
from stereorecal.reproduction._result_files import write_files as write_files
from stereorecal.reproduction._row_store import store_files as store_files
from stereorecal.reproduction._synthetic_log import synthetic_log as synthetic_log
from stereorecal.reproduction._tables import experiment_tables as experiment_tables
