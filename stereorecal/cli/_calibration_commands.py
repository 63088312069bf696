"""The options of the commands about calibration files."""

from stereorecal.cli._options import ARGUMENTS, READS, RUNNING, WRITES, argument, option, option_group
from stereorecal.cli._places import check_calibration
from stereorecal.cli._shared_options import FORMATS, CalibrationSizeOptions, ReportOptions


@option_group
class DiffOptions(ReportOptions, CalibrationSizeOptions):
    """What calibration B changes against calibration A of the same rig: rotation, direction and length of the baseline;
    and the errors of A if B is right: the epipolar error over the view, and the depth error at 5, 10, 30 and 100
    baselines.

    Exit code: 0 done; 2 bad input; 3 internal failure."""

    summary = "what one calibration changes against another"
    module = "stereorecal.cli._calibrations:diff"

    forms = ("A B",)
    before: str = argument(
        ARGUMENTS, "calibration file, LEFT,RIGHT if each camera has its own, or a folder", metavar="A"
    )
    after: str = argument(ARGUMENTS, "likewise", metavar="B")
    json: str | None = option(
        WRITES, "everything, as JSON, with a map of the epipolar error", metavar="FILE|-", writes=True
    )

    def check(self) -> None:
        super().check()
        for calibration in (self.before, self.after):
            check_calibration(calibration, calibration)


@option_group
class ConvertOptions(CalibrationSizeOptions):
    """Write a calibration in another format.

    Exit code: 0 done; 2 bad input, or the format cannot hold the calibration (nothing is written); 3 internal
    failure."""

    summary = "write a calibration in another format"
    module = "stereorecal.cli._calibrations:convert"

    forms = ("A B",)
    source: str = argument(
        ARGUMENTS, "calibration file, LEFT,RIGHT if each camera has its own, or a folder", metavar="A"
    )
    format: str | None = option(READS, f"of A (default: recognised): {FORMATS}", flag="--from", metavar="FORMAT")
    target: str = argument(ARGUMENTS, "new file, or LEFT,RIGHT", metavar="B")
    to: str | None = option(
        WRITES,
        "format of B, one of those of --from (default: stereorecal for .json, opencv for .yaml and .xml)",
        metavar="FORMAT",
    )
    template: bool = option(
        WRITES, "A is of no known format: write a calib.json to fill in, with the arrays of A", False
    )
    force: bool = option(WRITES, "replace B if it exists", False)
    quiet: bool = option(RUNNING, "print nothing", False)

    def check(self) -> None:
        super().check()
        check_calibration(self.source, self.source)
