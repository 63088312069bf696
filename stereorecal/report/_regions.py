"""Where in the image a calibration can be trusted, and where not, in words."""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

GRID = (8, 6)  # columns and rows of the regions of a misfit
PLACES = GRID[0] * GRID[1]
LIMIT = 0.2  # pixels of rows, beyond two standard errors: more than that and stereo matching suffers
_SPARSE = 0.25  # of a part of the view: fewer of its regions matched, and the part is not covered
_NEARLY_ALL = 0.7  # of the regions that matched: to name their parts would say less
_FEW = 4  # parts that fit into a headline
_PARTS = (
    ("upper left", "upper middle", "upper right"),
    ("left", "centre", "right"),
    ("lower left", "lower middle", "lower right"),
)


def sure(misfit: Mapping[str, Any], when: str) -> dict[int, float]:
    """By place, how many pixels its rows lie apart beyond two standard errors, in the frame where that is most.

    Args:
        when: "before" or "after": under which calibration.
    """
    found: dict[int, float] = {}
    for place, apart, error in zip(misfit["place"], misfit[when], misfit["error"], strict=True):
        found[place] = max(found.get(place, 0.0), abs(apart) - 2 * error)
    return found


def spoiled(misfit: Mapping[str, Any], when: str) -> list[int]:
    """Places whose rows lie too far apart for stereo matching; the worst first."""
    found = sure(misfit, when)
    return sorted((place for place, apart in found.items() if apart > LIMIT), key=lambda place: -found[place])


def in_short(misfit: Mapping[str, Any], when: str) -> str | None:
    """Where rows lie too far apart, in a few words; None if nowhere."""
    places = spoiled(misfit, when)
    if not places:
        return None
    parts = _parts(places)
    if _nearly_everywhere(places, misfit):
        return "nearly everywhere"
    return f"at the {_listed(parts)}" if len(parts) <= _FEW else f"in {len(parts)} parts of the image"


def where_not(misfit: Mapping[str, Any], when: str, whose: str = "", hence: str = "do not trust depth there") -> str:
    """One sentence on where rows lie apart.

    Args:
        when: "before" or "after": under which calibration.
        whose: what it is called, such as "With the candidate"; default nothing.
        hence: what follows from it.
    """
    places, regions = spoiled(misfit, when), len(set(misfit["place"]))
    begin = f"{whose}, in" if whose else "In"
    if not places:
        return f"{begin} none of the {regions} regions of the view that matched do rows lie more than {LIMIT} px apart."
    worst = max(abs(apart) for place, apart in zip(misfit["place"], misfit[when], strict=True) if place == places[0])
    here = "nearly everywhere" if _nearly_everywhere(places, misfit) else f"at the {_listed(_parts(places))}"
    return (
        f"{begin} {len(places)} of the {regions} regions of the view that matched rows lie more than {LIMIT} px apart "
        f"({worst:.2f} px at worst), {here}: {hence}."
    )


def unseen(misfit: Mapping[str, Any]) -> str | None:
    """One sentence on the parts of the view that hardly anything is known of; None if there are none."""
    found, all_places = Counter(map(_part, set(misfit["place"]))), Counter(map(_part, range(PLACES)))
    parts = [part for part, number in all_places.items() if found[part] < _SPARSE * number]
    if not parts:
        return None
    return f"Little or nothing matched at the {_listed(parts)}: what is said of it is extrapolated."


def _part(place: int) -> str:
    row, column = divmod(place, GRID[0])
    return _PARTS[3 * row // GRID[1]][3 * column // GRID[0]]


def _parts(places: Iterable[int]) -> list[str]:
    """All parts of the view that hold one of the places; those that hold most first."""
    return [part for part, _ in Counter(map(_part, places)).most_common()]


def _nearly_everywhere(places: list[int], misfit: Mapping[str, Any]) -> bool:
    return len(places) >= _NEARLY_ALL * len(set(misfit["place"]))


def _listed(parts: list[str]) -> str:
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)
