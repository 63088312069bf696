"""The matrices of OpenCV's functions in files: under the names of OpenCV's samples, else found by shape and side."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from stereorecal._errors import InputError
from stereorecal.io.formats._format import Documents, Hints
from stereorecal.io.formats._matrix_entries import Entry, entries_of
from stereorecal.io.formats._matrix_roles import (
    cameras_in,
    lenses_in,
    rectifications_in,
    rotation_in,
    size_in,
    translation_in,
)
from stereorecal.io.formats._numbers import image_size, pixels
from stereorecal.io.formats.text._keys import Keys

MATRICES = ("K", "M", "cameraMatrix", "camera_matrix_", "intrinsic")
_DISTORTIONS = ("D", "distCoeffs", "dist_coeffs_", "distortion_coefficients_")
_SIZES = ("imageSize", "image_size", "imgSize", "size", "res1")


@dataclass(frozen=True)
class Matrices:
    """The values of some documents, and which of them is which.

    Attributes:
        content: every value by its name: the keys that lead to it, joined by dots.
        places: for each name, the number of its document, and its keys.
        names: of K1, D1, K2, D2, R, T, and, where the file has them, R1, R2, P1, P2; of what is not found, the name
            that OpenCV's samples give it.
    """

    content: Mapping[str, Any]
    places: Mapping[str, Keys]
    names: Mapping[str, str]
    entries: tuple[Entry, ...]

    @staticmethod
    def of(documents: Documents) -> "Matrices":
        """What documents hold.

        Raises:
            InputError: if there are two readings.
        """
        entries = entries_of(documents)
        content = {entry.name: entry.value for entry in entries}
        return Matrices(content, {entry.name: entry.place for entry in entries}, _names(entries, content), (*entries,))

    def has(self, *roles: str) -> bool:
        """Whether all of these are there."""
        return all(self.names.get(role) in self.content for role in roles)

    def own_name(self, key: str) -> str | None:
        """What a derived matrix, such as P1 or Q, is called, if it is there under its usual key."""
        if key in self.names or key in self.content:
            return self.names.get(key, key)
        inside = [name for name, place in self.places.items() if place[-1] == key]
        return inside[0] if len(inside) == 1 else None

    def size(self, hints: Hints) -> tuple[int, int]:
        """Of the images.

        Raises:
            InputError: if neither the file nor the hints have one.
        """
        for key in _SIZES:
            if key in self.content:
                return image_size(self.content, key)
        if "image_width" in self.content:
            return pixels(self.content, "image_width"), pixels(self.content, "image_height")
        found = size_in(self.entries) or hints.size
        if found is None:
            raise InputError(
                "the file has no image size (imageSize); give size=(width, height), on the command line --size WxH."
            )
        return found


def _names(entries: list[Entry], content: Mapping[str, Any]) -> dict[str, str]:
    names: dict[str, str] = {}
    for role, usual, found_in in (("K", MATRICES, cameras_in), ("D", _DISTORTIONS, lenses_in)):
        by_sides = [{side for side in (1, 2) if f"{name}{side}" in content} for name in usual]
        exact = next((name for name, sides in zip(usual, by_sides, strict=True) if len(sides) == 2), None)
        found = None if exact else found_in(entries)
        exact = exact or next((name for name, sides in zip(usual, by_sides, strict=True) if sides), None)
        for index, side in enumerate((1, 2)):
            names[f"{role}{side}"] = found[index].name if found else f"{exact or usual[0]}{side}"
    between: tuple[tuple[str, Callable[[list[Entry]], Entry | None]], ...] = (
        ("R", rotation_in),
        ("T", translation_in),
    )
    for role, one_in in between:
        one = None if role in content else one_in(entries)
        names[role] = one.name if one else role
    if not {names["R"], names["T"]} & content.keys():
        rectified = rectifications_in(entries)
        for role, pair in zip("RP", rectified or (), strict=False):
            names |= {f"{role}{side}": entry.name for side, entry in enumerate(pair, start=1)}
    return names
