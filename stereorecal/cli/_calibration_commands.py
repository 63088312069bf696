"""The options of the commands about calibration files."""

from stereorecal.cli._options import CommonOptions, argument, option, option_group
from stereorecal.cli._places import check_calibration, check_places, one_file
from stereorecal.cli._shared_options import FORMATS, READS, WRITES, CalibrationOptions, ReportOptions


@option_group
class _ComparedCalibrations:
    """Two calibrations of one rig."""

    title = READS
    before: str = argument("calibration file, LEFT,RIGHT if each camera has its own, or a folder", metavar="A")
    after: str = argument("likewise", metavar="B")


@option_group
class DiffOptions(_ComparedCalibrations, CalibrationOptions, ReportOptions, CommonOptions):
    """What calibration B changes against calibration A of the same rig: rotation, direction and length of the baseline;
    and the errors of A if B is right: the epipolar error over the view, and the depth error at 5, 10, 30 and 100
    baselines.

    Exit code: 0 done; 2 bad input; 3 internal failure."""

    summary = "what one calibration changes against another"
    module = "stereorecal.cli._calibrations:diff"

    forms = ("A B",)
    json: str | None = option(
        "everything, as JSON, with a map of the epipolar error", metavar="FILE|-", writes=one_file
    )

    def check(self) -> None:
        check_places(self.places, force=self.force)
        for calibration in (self.before, self.after):
            check_calibration(calibration, calibration)


@option_group
class _ConvertedCalibration:
    """A calibration and its copy."""

    title = READS
    source: str = argument("calibration file, LEFT,RIGHT if each camera has its own, or a folder", metavar="A")
    format: str | None = option(f"of A (default: recognised): {FORMATS}", flag="--from", metavar="FORMAT")


@option_group
class _NewCalibration:
    """The copy."""

    title = WRITES
    target: str = argument("new file, or LEFT,RIGHT", metavar="B")
    to: str | None = option(
        "format of B, one of those of --from (default: stereorecal for .json, opencv for .yaml and .xml)",
        metavar="FORMAT",
    )
    template: bool = option("A is of no known format: write a calib.json to fill in, with the arrays of A", False)
    force: bool = option("replace B if it exists", False)


@option_group
class ConvertOptions(_ConvertedCalibration, CalibrationOptions, _NewCalibration, CommonOptions):
    """Write a calibration in another format.

    Exit code: 0 done; 2 bad input, or the format cannot hold the calibration (nothing is written); 3 internal
    failure."""

    summary = "write a calibration in another format"
    module = "stereorecal.cli._calibrations:convert"

    forms = ("A B",)
    quiet: bool = option("print nothing", False)

    def check(self) -> None:
        check_calibration(self.source, self.source)
