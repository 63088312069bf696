"""The unit of lengths in a calibration file that is written."""

from stereorecal.cli._calibration_paths import CalibrationPath
from stereorecal.geometry import StereoRig
from stereorecal.io import says_its_unit, unsaid_unit


def output_unit(
    read: StereoRig, written: StereoRig, target: CalibrationPath, format: str | None, unit: str | None
) -> tuple[str | None, str]:
    """What --unit means for a file that is written, and what to say of it after "written".

    It is about the file that was read, if only that one says no unit.
    """
    unsaid = unsaid_unit(written, target, format=format)
    if unsaid is None:
        return unit if says_its_unit(read) else None, ""
    return unit, f" (translation in {unit or unsaid})"
