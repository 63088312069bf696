"""Files that hold the calibration of a device at each of its image sizes."""

from collections.abc import Sequence

from stereorecal._errors import InputError
from stereorecal.io.formats._format import Hints


def chosen_mode(sizes: Sequence[tuple[int, int]], hints: Hints) -> tuple[int, int]:
    """The size of the images, of which the file has to have a calibration.

    Raises:
        InputError: if it has none, or several while the size is not known.
    """
    listed = ", ".join(f"{width}x{height}" for width, height in sorted(sizes))
    if not sizes:
        raise InputError("there is no image size at which the file has both cameras; save the calibration again.")
    if hints.size is None and len(sizes) > 1:
        raise InputError(
            f"the file has calibrations for images of {listed}; give size=(width, height), on the command line --size "
            "WxH."
        )
    if hints.size is not None and hints.size not in sizes:
        width, height = hints.size
        raise InputError(
            f"the images are {width}x{height}, and the file has calibrations for {listed}; use images of one of these "
            "sizes, or give one of them and change the rig: rig.resized(size), rig.cropped(size)."
        )
    return hints.size or sizes[0]
