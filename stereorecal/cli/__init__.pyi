from ._commands import options_of as options_of, parser as parser
from ._executors import executor as executor
from ._experiment_commands import CompareOptions as CompareOptions
from ._main import main as main
from ._of_the_library import (
    Progress as Progress,
    checked_choice as checked_choice,
    existing_folder as existing_folder,
    extra as extra,
    hold as hold,
    run_all as run_all,
    versions as versions,
)
from ._option_values import number_or_all as number_or_all
from ._options import (
    READS as READS,
    RIG as RIG,
    RUNNING as RUNNING,
    SEARCH as SEARCH,
    WRITES as WRITES,
    CommonOptions as CommonOptions,
    argument as argument,
    option as option,
    option_group as option_group,
    value_of as value_of,
)
from ._output_files import (
    GrowingJson as GrowingJson,
    check_extra as check_extra,
    deliver as deliver,
    write_json as write_json,
)
from ._places import Place as Place, check_places as check_places, refuse_replacing_inputs as refuse_replacing_inputs
from ._shared_options import (
    MatcherOptions as MatcherOptions,
    ReachOptions as ReachOptions,
    ReportOptions as ReportOptions,
    WorkerOptions as WorkerOptions,
)
from ._signals import BAD_INPUT as BAD_INPUT, FAILURE as FAILURE, INTERRUPTED as INTERRUPTED
from ._streams import say as say
from ._terminal import progress_bar as progress_bar, table_console as table_console
