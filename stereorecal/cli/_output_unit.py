"""The unit of lengths in a calibration file that is written."""

from stereorecal.cli._calibration_paths import CalibrationPath
from stereorecal.geometry import StereoRig
from stereorecal.io import unit_read, unsaid_unit


def output_unit(
    read: StereoRig, written: StereoRig, target: CalibrationPath, format: str | None, unit: str | None
) -> tuple[str | None, str]:
    """What --unit means for a file that is written, and what to say of it after "written".

    It is about the file that was read, if that was read with it, and the format of the new one has a unit.
    """
    unsaid = unsaid_unit(written, target, format=format)
    if unsaid is None:
        return None if unit_read(read) == unit else unit, ""
    return unit, f" (translation in {unit or unsaid})"
