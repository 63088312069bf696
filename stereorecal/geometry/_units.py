"""Units of length, and whether a baseline is as long as baselines are."""

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
_WORDS = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "in": "inches"}
_USUAL = (0.005, 5.0)  # metres, from the smallest endoscope to the longest ship's rig


def inferred_unit(length: float) -> str:
    """Metres, if a baseline of that length would be a usual one, else millimetres."""
    return "m" if length <= _USUAL[1] else "mm"


def doubt_of_length(metres: float, unit: str) -> str | None:
    """What to say of a baseline whose length speaks of another unit than the one in which it was given; None if it is
    a usual one."""
    shortest, longest = _USUAL
    if shortest <= metres <= longest:
        return None
    advice = f"check that the translation is in {_WORDS[unit]}, or give its unit (--unit)"
    return f"the baseline is {metres:.3g} m long; {advice}."
