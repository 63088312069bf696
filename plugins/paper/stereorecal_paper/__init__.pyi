from ._experiments import EXPERIMENTS as EXPERIMENTS, QUICK as QUICK, Extent as Extent, methods as methods
from ._figures import experiment_figures as experiment_figures
from ._missions import MissionPlan as MissionPlan, PlannedMission as PlannedMission, plan_missions as plan_missions
from ._options import ReproduceOptions as ReproduceOptions
from ._plain_log import (
    has_mission as has_mission,
    save_calibrations as save_calibrations,
    save_mission as save_mission,
)
from ._reproduce import Reproduction as Reproduction, reproduce as reproduce
from ._result_files import write_files as write_files
from ._synthetic_log import synthetic_log as synthetic_log
from ._tables import experiment_tables as experiment_tables
