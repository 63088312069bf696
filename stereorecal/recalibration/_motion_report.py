"""What the rig's own motion told, as plain data and in a line."""

from typing import Any

import numpy as np

from stereorecal.estimation import Estimate

_ODOMETER_FITS = 0.1  # of the way: drifts of the baseline are smaller


def motion_as_dict(estimated: Estimate) -> dict[str, Any]:
    """What the rig's own motion told, as plain data: how many windows, points that were followed, those that fit the
    motion of the rig, the median of its way from one pair to the next, NaN if too few could be followed, in how many
    windows it hardly moved or only turned, which tells nothing of depth, and by how much the right shutter may be late,
    None if it is not."""
    several = [one for one in estimated.motions if one.motion is not None]
    inliers, tracks = (sum(getattr(one, name) for one in several) for name in ("inliers", "tracks"))
    way = float(np.median([one.metres[0] for one in several])) if several else float("nan")
    still = sum(not one.informative for one in several)
    summary = {"windows": len(estimated.windows.tracks), "followed": tracks, "fitting": inliers, "metres": way}
    summary |= {"without_parallax": still}
    delay = estimated.delay and {
        "probability": estimated.delay.probability,
        "value": estimated.delay.seconds,
        "unit": _unit(estimated),
    }
    return summary | {"delay": delay}


def _unit(estimated: Estimate) -> str:
    """Of a delay: where times are not known, all windows last 1, and no two pairs of known times are so far apart."""
    return "pairs" if set(estimated.windows.seconds) == {1.0} else "s"


def motion_text(estimated: Estimate) -> str:
    """What the rig's own motion told, in a line."""
    summary = motion_as_dict(estimated)
    if not summary["followed"]:
        return f"{summary['windows']} windows, too few points could be followed"
    return (
        f"{summary['windows']} windows, {summary['fitting']} of {summary['followed']} points fit the motion of the "
        f"rig, {summary['metres']:.3g} m from one pair to the next (median)"
        + _still(summary)
        + (_late(summary["delay"]) if estimated.is_late else "")
    )


def _still(summary: dict[str, Any]) -> str:
    some = summary["without_parallax"]
    return f"; in {some} of them the rig only turned or stood still, which tells nothing of depth" if some else ""


def _late(delay: dict[str, Any]) -> str:
    unit = "s" if delay["unit"] == "s" else "of the time between pairs"
    return f"; the right shutter is late by {delay['value']:.2g} {unit}"


def odometer_text(estimated: Estimate) -> str:
    """What came of the distances travelled that were given."""
    known = [
        (way[0], one.metres[0])
        for way, one in zip(estimated.windows.all_ways, estimated.motions, strict=True)
        if way is not None and one.motion is not None and one.informative
    ]
    if not known:
        return "not used: in no window that it knows did the rig advance far enough"
    given, moved = np.median(known, axis=0).tolist()
    fits = f"it knows {len(known)} of {len(estimated.windows.tracks)} windows"
    if abs(given - moved) <= _ODOMETER_FITS * moved:
        return fits
    return (
        f"{fits}, and does not fit: {given:.3g} m where motion shows {moved:.3g} m (median); check its unit and clock"
    )
