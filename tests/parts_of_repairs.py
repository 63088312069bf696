"""What lies inside of repairs, the watch, files, reports and the command line, and is looked at or stood in for.

See `parts_of_estimates`.
"""

from stereorecal import _compile_cache as _compile_cache
from stereorecal._plugins import Plugin as Plugin
from stereorecal.cli import _cluster as _cluster, _signals as _signals
from stereorecal.cli._commands import COMMANDS as COMMANDS
from stereorecal.cli._jax_setup import use_compile_cache as use_compile_cache
from stereorecal.cli._live_view import (
    away as away,
    next_step as next_step,
    reason as reason,
    undetermined as undetermined,
)
from stereorecal.comparison import _trial as _trial
from stereorecal.io.formats import _read_rig as _read_rig
from stereorecal.io.formats._format import JSON as JSON, YAML as YAML, Format as Format, Hints as Hints
from stereorecal.io.formats._numbers import image_size as image_size, numbers as numbers, value as value
from stereorecal.io.formats._read_rig import as_in_file as as_in_file, named as named, scaled as scaled
from stereorecal.io.formats._table import Lens as Lens, Pose as Pose, Table as Table, places as places
from stereorecal.io.formats.text import _yaml as _yaml
from stereorecal.io.formats.text._document import Syntax as Syntax, document as document
from stereorecal.io.formats.text._nodes import number_or_word as number_or_word, plain as plain
from stereorecal.io.images import _image_files as _image_files, _load_pairs as _load_pairs
from stereorecal.io.images._image_files import check_header as check_header, decode_image as decode_image
from stereorecal.online import (
    _advice as _advice,
    _calibration_kinds as _calibration_kinds,
    _moving as _moving,
    _switching as _switching,
)
from stereorecal.recalibration._assessment import share_lost as share_lost
from stereorecal.recalibration._match_ranges import match_ranges as match_ranges
from stereorecal.recalibration._mismatch import mismatch_of as mismatch_of
from stereorecal.recalibration._motion_windows import (
    MOST_WINDOWS as MOST_WINDOWS,
    check_odometer as check_odometer,
    following as following,
)
from stereorecal.recalibration._prior_use import (
    fingerprint as fingerprint,
    known_after as known_after,
    prior_use as prior_use,
)
from stereorecal.recalibration._recalibrate import prepared as prepared
from stereorecal.recalibration._repair_report import conclusion_of as conclusion_of, report_of as report_of
from stereorecal.recalibration._row_residuals import (
    Misfit as Misfit,
    row_errors_and_misfit as row_errors_and_misfit,
)
from stereorecal.recalibration._search import run_schedule as run_schedule
from stereorecal.recalibration._stages import started as started
from stereorecal.recalibration._uncertainty import uncertainty as uncertainty
from stereorecal.report._repair_figures import (
    _bins as _bins,
    density as density,
    expected_figure as expected_figure,
    field_figures as field_figures,
    histogram_figure as histogram_figure,
    outline as outline,
)
