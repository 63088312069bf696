"""Judges of calibrations: what no method looks at says how good a rig is, but for rows of lidar and of given drives.

`_*_judge.py` are the judges, listed in `_judges.py`; the other modules are what they measure by.
"""

from stereorecal.comparison import DISTANCES as DISTANCES
from stereorecal_field.judges._board_errors import ByBoards as ByBoards, by_boards as by_boards
from stereorecal_field.judges._case import AbstractRecipe as AbstractRecipe, Case as Case, case_of as case_of
from stereorecal_field.judges._draws import Draws as Draws
from stereorecal_field.judges._judgement import (
    ROWS_WORSE as ROWS_WORSE,
    Judgement as Judgement,
)
from stereorecal_field.judges._judges import RENDERED as RENDERED, recipes_of as recipes_of
from stereorecal_field.judges._rows import row_error_px as row_error_px
from stereorecal_field.judges._true_disparity import (
    BINS as BINS,
    DepthByTruth as DepthByTruth,
    depth_by_truth as depth_by_truth,
    scene_with_truth as scene_with_truth,
)
from stereorecal_field.judges._walk_judge import walked as walked
