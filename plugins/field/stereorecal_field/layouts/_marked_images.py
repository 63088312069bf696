"""Left and right images in one folder, which the last letter of their names tells apart."""

from pathlib import Path

from stereorecal import InputError
from stereorecal.io.layouts import Matched, by_stem, match_keys


def match_marked(folder: Path) -> Matched:
    """The images NAMEL.* and NAMER.* of one folder.

    Raises:
        InputError: if there is none, or naming an image without a partner.
    """
    files = by_stem(folder)
    left, right = ({stem[:-1]: path for stem, path in files.items() if stem.endswith(mark)} for mark in "LR")
    if not (left or right):
        raise InputError(
            f"{folder}: no image in there has a name that ends in L or R, such as 00000001L.jpg; add some."
        )
    return match_keys(left, right)
