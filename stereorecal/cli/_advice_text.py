"""What to show a rig next, for the person who has it in hand."""

from dataclasses import replace

from stereorecal.online import BAND_EDGES, Advice, Showing, Undetermined
from stereorecal.report.number_text import distance

_WORDS = {"epipolar": "epipolar error", "depth": "depth"}
_ROWS, _COLUMNS = ("upper", "", "lower"), ("left", "", "right")
_ALONE = {"upper": "at the top", "lower": "at the bottom", "left": "on the left", "right": "on the right"}


def next_step(found: Advice, baseline: float) -> str:
    """What to do next.

    Args:
        baseline: metres.
    """
    if found.blind:
        return "turn the rig towards something with texture, in good light"
    if found.show is not None:
        return _showing(found.show, baseline)
    if any(one.error == "depth" for one in found.undetermined):
        return "nothing to be seen here would tell more of depth; measured distances would (recalibrate --ranges)"
    return "nothing: the answer stands" if found.stands else "go on: later pairs decide"


def _showing(show: Showing, baseline: float) -> str:
    if show.motion:
        past = "" if show.distance is None else f" past something {away(show.distance, baseline)}"
        return f"drive on{past}{': depth needs motion' if show.narrows.error == 'depth' else ''}"
    assert show.part is not None
    assert show.distance is not None
    row, column = _ROWS[show.part[0]], _COLUMNS[show.part[1]]
    place = f"in the {row} {column}" if row and column else _ALONE.get(row or column, "in the middle")
    return f"show something {away(show.distance, baseline)}, {place} of the view"


def reason(found: Advice, baseline: float) -> str:
    """What that narrows, and by how much; empty where it narrows nothing."""
    if found.blind or found.show is None:
        return ""
    narrows = found.show.narrows
    after = replace(narrows, half_width=found.show.half_width)
    name = f"{_WORDS[narrows.error]} at {distance(narrows.distance * baseline)}"
    return f"{name}: {_half_width(narrows, baseline)} now, {_half_width(after, baseline)} then"


def undetermined(found: Advice, baseline: float) -> str:
    """What is known less well than matters, such as "epipolar error at 60 cm, 1.2 m (± 1.06 px); depth at 3.6 m (± 25
    cm); axes pitch, yaw"."""
    told = []
    for error, word in _WORDS.items():
        if those := [one for one in found.undetermined if one.error == error]:
            where = ", ".join(distance(one * baseline) for one in sorted(each.distance for each in those))
            told.append(f"{word} at {where} ({_half_width(those[0], baseline)})")
    return "; ".join([*told, f"axes {', '.join(found.axes)}"] if found.axes else told) or "nothing"


def _half_width(one: Undetermined, baseline: float) -> str:
    if one.error == "epipolar":
        return f"± {one.half_width:.2f} px"
    return f"± {distance(0.01 * one.half_width * one.distance * baseline)}"


def away(baselines: float, baseline: float) -> str:
    """The distances that count as one: "within 85 cm", "85 cm to 2.1 m away", "farther than 6.6 m"."""
    lengths = [distance(edge * baseline) for edge in BAND_EDGES]
    band = sum(edge < baselines for edge in BAND_EDGES)
    if band == 0:
        return f"within {lengths[0]}"
    if band == len(BAND_EDGES):
        return f"farther than {lengths[-1]}"
    low, high = lengths[band - 1 : band + 1]
    number, unit = low.split()
    return f"{number if high.endswith(f' {unit}') else low} to {high} away"
