"""What a page says that its code prints, compared with what it does print."""

import re

_NUMBER = re.compile(r"[+-]?\d+(?:[ \u202f]\d{3}\b)*(?:\.\d*)?(?:e[+-]?\d+)?")
_TOKEN = re.compile(rf"{_NUMBER.pattern}|\w+|[^\w\s]")
_SECONDS = re.compile(r"\d+(?:\.\d+)?(?= ?s\b)")
_START, _END = "\x02", "\x03"
_UNITS, _SHARE = 2.001, 0.25


def agrees(shown: str, printed: str) -> bool:
    """Whether a page shows what was printed.

    "…" stands for anything, the width of spaces does not matter, seconds are free, and other numbers may differ by 25 %
    or two units of their last decimal: programs that are compiled otherwise round otherwise, and match other pixels.
    """
    words, place = _tokens(f"{_START}{printed}{_END}"), 0
    for part in map(_tokens, f"{_START}{shown}{_END}".split("…")):
        places = range(place, len(words) - len(part) + 1)
        found = next((start for start in places if all(map(_same, part, words[start:]))), None)
        if found is None:
            return False
        place = found + len(part)
    return True


def _tokens(text: str) -> list[str]:
    return _TOKEN.findall(_SECONDS.sub("0", text))


def _same(shown: str, printed: str) -> bool:
    if not (_NUMBER.fullmatch(shown) and _NUMBER.fullmatch(printed)):
        return shown == printed
    one, other = (float(re.sub(r"\s", "", number)) for number in (shown, printed))
    decimals = max(len(number.partition("e")[0].partition(".")[2]) for number in (shown, printed))  # NumPy drops zeros
    return abs(one - other) <= max(_UNITS * 10.0**-decimals if decimals else 0.0, _SHARE * abs(one))
