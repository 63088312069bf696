"""Where depth can be trusted, and where not, in words: the regions of the view whose epipolar error is too large."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

from stereorecal.report.repair_report import Conclusion, RepairReport

GRID = (8, 6)  # columns and rows of the regions of a misfit
PLACES = GRID[0] * GRID[1]
LIMIT = 0.2  # pixels of epipolar error, beyond two standard errors: above it, stereo matching degrades
_SPARSE = 0.25  # of a part of the view: with fewer matched regions, the part is not covered
_NEARLY_ALL = 0.7  # of the matched regions: then the parts are not listed
_PARTS = (
    ("upper left", "upper middle", "upper right"),
    ("left", "centre", "right"),
    ("lower left", "lower middle", "lower right"),
)

_NOT_MEASURED = (
    "Epipolar errors were not measured, only matches counted: it is not known where in the image depth can be trusted."
)


def misaligned(misfit: Mapping[str, Any], when: str) -> list[int]:
    """Places whose epipolar error, beyond two standard errors, degrades stereo matching in some frame, "before" or
    "after"; the worst first."""
    found: dict[int, float] = {}
    for place, offset, error in zip(misfit["place"], misfit[when], misfit["error"], strict=True):
        found[place] = max(found.get(place, 0.0), abs(offset) - 2 * error)
    return sorted((place for place, error in found.items() if error > LIMIT), key=lambda place: -found[place])


def misfit_sentence(
    misfit: Mapping[str, Any], when: str, whose: str = "", hence: str = "do not trust depth there"
) -> str:
    """One sentence on where the epipolar error is too large, "before" or "after", under `whose` calibration, and what
    follows from it."""
    places, regions = misaligned(misfit, when), len(set(misfit["place"]))
    begin = f"{whose}, in" if whose else "In"
    if not places:
        return f"{begin} none of the {regions} matched regions of the view does the epipolar error exceed {LIMIT} px."
    offsets = zip(misfit[when], misfit["error"], strict=True)
    worst = max(abs(offset) for offset, error in offsets if abs(offset) - 2 * error > LIMIT)
    everywhere = len(places) >= _NEARLY_ALL * regions
    parts = [part for part, _ in Counter(map(_part, places)).most_common()]  # those that hold most of them first
    here = "nearly everywhere" if everywhere else f"at the {_listed(parts)}"
    return (
        f"{begin} {len(places)} of the {regions} matched regions of the view the epipolar error exceeds {LIMIT} px "
        f"({worst:.2f} px at worst), {here}: {hence}."
    )


def coverage_sentence(misfit: Mapping[str, Any]) -> str | None:
    """One sentence on the parts of the view with hardly any matches; None if there are none."""
    found, all_places = Counter(map(_part, set(misfit["place"]))), Counter(map(_part, range(PLACES)))
    parts = [part for part, number in all_places.items() if found[part] < _SPARSE * number]
    if not parts:
        return None
    return f"Little or nothing matched at the {_listed(parts)}: the errors there are extrapolated."


def _part(place: int) -> str:
    row, column = divmod(place, GRID[0])
    return _PARTS[3 * row // GRID[1]][3 * column // GRID[0]]


def _listed(parts: list[str]) -> str:
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def where(report: RepairReport) -> list[str]:
    """Where the epipolar error is too large: of the calibration to use, and of a candidate that was refused."""
    if report.misfit is None:
        return [_NOT_MEASURED] if report.conclusion in (Conclusion.REPAIRED, Conclusion.GOOD) else []
    sentences = [
        misfit_sentence(report.misfit, report.when, "" if report.accepted else "With the calibration that you keep")
    ]
    if report.conclusion is Conclusion.REFUSED:
        sentences.append(
            misfit_sentence(report.misfit, "after", "With the candidate, which was rejected", "it does not fit there")
        )
    return [*sentences, *filter(None, [coverage_sentence(report.misfit)])]
