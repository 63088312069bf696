"""What lies inside of repairs, the watch and the command line, and is looked at or stood in for.

See `parts_of_estimates`.
"""

from stereorecal import _compile_cache as _compile_cache
from stereorecal.cli import _cluster as _cluster, _signals as _signals
from stereorecal.cli._commands import COMMANDS as COMMANDS
from stereorecal.cli._jax_setup import use_compile_cache as use_compile_cache
from stereorecal.online import _moving as _moving, _switching as _switching
from stereorecal.recalibration._assessment import share_lost as share_lost
from stereorecal.recalibration._match_ranges import match_ranges as match_ranges
from stereorecal.recalibration._mismatch import mismatch_of as mismatch_of
from stereorecal.recalibration._motion_windows import (
    MOST_WINDOWS as MOST_WINDOWS,
    check_odometer as check_odometer,
    following as following,
)
from stereorecal.recalibration._prior_use import fingerprint as fingerprint, prior_use as prior_use
from stereorecal.recalibration._recalibrate import prepared as prepared
from stereorecal.recalibration._repair_report import conclusion_of as conclusion_of, report_of as report_of
from stereorecal.recalibration._row_residuals import Cause as Cause, RowResiduals as RowResiduals, misfit as misfit
from stereorecal.recalibration._search import run_schedule as run_schedule
from stereorecal.recalibration._stages import started as started
from stereorecal.recalibration._uncertainty import uncertainty as uncertainty
