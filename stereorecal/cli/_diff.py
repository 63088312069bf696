"""`python -m stereorecal diff`."""

from stereorecal._version import versions
from stereorecal.cli._calibration_commands import DiffOptions
from stereorecal.cli._calibration_files import rig_at, says_no_unit
from stereorecal.cli._output_files import deliver, write_json
from stereorecal.cli._output_places import refuse_replacing_inputs
from stereorecal.io import files_read
from stereorecal.recalibration import Difference, difference

SCHEMA = "stereorecal.difference/1"


def run(options: DiffOptions) -> int:
    """Compare, save, print; returns the exit code."""
    with files_read() as read:
        before, after = (
            rig_at(words, options, other_says_none=options.unit is not None and says_no_unit(other, options))
            for words, other in ((options.before, options.after), (options.after, options.before))
        )
        found = difference(before, after)
    refuse_replacing_inputs(options.places, read)
    names = {"before": options.before, "after": options.after}
    content = {"schema": SCHEMA, "versions": versions(), **names, **found.as_dict()}
    deliver(lambda: _show(found, options), lambda: write_json(content, options.json, force=options.force))
    return 0


def _show(found: Difference, options: DiffOptions) -> None:
    if options.prints:
        print(found)
        print("epipolar error over the view, depth straight ahead: how wrong the first is if the second is right")
