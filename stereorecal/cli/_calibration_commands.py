"""The options of the commands about calibration files."""

from stereorecal.cli._options import CommonOptions, argument, option, option_group
from stereorecal.cli._shared_options import FORMATS, CalibrationOptions, ReportOptions


@option_group
class DiffOptions(CalibrationOptions, ReportOptions, CommonOptions):
    """What calibration B changes against calibration A of the same rig: rotation, direction and length of the baseline;
    and, for those who use A if B is right, the epipolar error over the view and the depth error at 5, 10, 30 and 100
    baselines. Without --unit, the unit of a file that states none is inferred from its baseline. Exit code: 0 done; 2
    bad input; 3 internal failure."""

    before: str = argument(
        "calibration file of any format, LEFT,RIGHT where each camera has its own, or a folder", metavar="A"
    )
    after: str = argument("likewise", metavar="B")
    json: str | None = option("write everything as JSON, with a map of the epipolar error", metavar="FILE|-")


@option_group
class ConvertOptions(CalibrationOptions, CommonOptions):
    """Write a calibration in another format. Where a format has a file for each camera, name both as LEFT,RIGHT. Exit
    code: 0 done; 2 bad input, also where the format cannot hold the calibration: nothing is written then; 3 internal
    failure."""

    source: str = argument("calibration file, LEFT,RIGHT, or a folder that holds them", metavar="A")
    target: str = argument("new file, or LEFT,RIGHT", metavar="B")
    to: str | None = option(
        f"of B (default: stereorecal for .json, opencv for .yaml and .xml): {FORMATS}", metavar="FORMAT"
    )
    format: str | None = option(f"of A (default: recognised): {FORMATS}", flag="--from", metavar="FORMAT")
    force: bool = option("B may be replaced", False)
    quiet: bool = option("print nothing", False)
