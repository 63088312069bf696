"""The choice between KITTI's grey and colour cameras: folders of the left and the right one."""

from collections.abc import Sequence
from pathlib import Path

from stereorecal._errors import InputError

Sides = tuple[str, str]


def sides_in(folder: Path, choices: Sequence[Sides]) -> Sides:
    """The first choice whose left and right folder both exist.

    Raises:
        InputError: if there is none.
    """
    for sides in choices:
        if all((folder / side).is_dir() for side in sides):
            return sides
    wanted = ", or ".join(f"{left} and {right}" for left, right in choices)
    raise InputError(f"{folder}: both cameras are needed, the folders {wanted}; unpack the images of the other one.")
