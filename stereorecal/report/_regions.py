"""Where in the image a repair can be trusted, and where not, in words."""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

GRID = (8, 6)  # columns and rows of the regions of a misfit
LIMIT = 0.2  # pixels of rows, beyond two standard errors: more than that and stereo matching suffers
_SPARSE = 0.25  # of a part of the view: fewer of its regions matched, and the part is not covered
_PARTS = (
    ("upper left", "upper middle", "upper right"),
    ("left", "centre", "right"),
    ("lower left", "lower middle", "lower right"),
)


def spoiled(misfit: Mapping[str, Any]) -> list[tuple[int, int, float]]:
    """Regions whose rows stay apart: the frame, the place in it and by how many pixels; the worst first."""
    regions = zip(misfit["frame"], misfit["place"], misfit["after"], misfit["error"], strict=True)
    apart = [(frame, place, after) for frame, place, after, error in regions if abs(after) - 2 * error > LIMIT]
    return sorted(apart, key=lambda region: -abs(region[2]))


def where_not(misfit: Mapping[str, Any]) -> str:
    """One or two sentences on where rows stay apart, and which parts of the view nothing is known of."""
    apart, regions = spoiled(misfit), len(misfit["place"])
    unseen = _unseen(misfit["place"])
    parts = []
    if apart:
        number = f"{len(apart)} of {regions} regions"
        places = _named(place for _, place, _ in apart)
        parts.append(
            f"In {number} rows stay more than {LIMIT} px apart ({abs(apart[0][2]):.2f} px at worst), at the "
            f"{places}: do not trust depth there."
        )
    else:
        parts.append(f"In none of the {regions} regions that matched do rows stay more than {LIMIT} px apart.")
    if unseen:
        parts.append(f"Nothing or little matched at the {_listed(unseen)}: what is said of it is extrapolated.")
    return " ".join(parts)


def _part(place: int) -> str:
    row, column = divmod(place, GRID[0])
    return _PARTS[3 * row // GRID[1]][3 * column // GRID[0]]


def _named(places: Iterable[int]) -> str:
    """The parts of the view that hold most of the places, at most three."""
    counts = Counter(map(_part, places))
    return _listed([part for part, _ in counts.most_common(3)])


def _unseen(places: Iterable[int]) -> list[str]:
    """The parts of the view in which hardly a region matched, in any frame."""
    found = Counter(map(_part, set(places)))
    return [
        part for part, number in Counter(map(_part, range(GRID[0] * GRID[1]))).items() if found[part] < _SPARSE * number
    ]


def _listed(parts: list[str]) -> str:
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)
