"""What a page says that its code prints, compared with what it does print."""

import re

_NUMBER = re.compile(r"[+-]?\d+(?:[ \u202f]\d{3}\b)*(?:\.\d*)?(?:e[+-]?\d+)?")
_TOKEN = re.compile(rf"{_NUMBER.pattern}|\w+|[^\w\s]")
_SECONDS = re.compile(r"\d+(?:\.\d+)?(?= ?s\b)")
_START, _END = "\x02", "\x03"
_APART, _SHARE, _SHARE_OF_WHOLE = 0.051, 0.25, 0.1


def agrees(shown: str, printed: str) -> bool:
    """Whether a page shows what was printed.

    "…" stands for anything, the width of spaces does not matter, seconds are free, and whole numbers hold to a tenth,
    others to a quarter or to 0.05: programs that are compiled otherwise round otherwise.
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
    shown, printed = (re.sub(r"\s", "", number) for number in (shown, printed))
    one, other = float(shown), float(printed)
    if shown.isdigit():  # below ten: few of something, a unit, a name
        return abs(one - other) <= (_SHARE_OF_WHOLE * one if one >= 10 else 0.0)
    return abs(one - other) <= max(_APART, _SHARE * abs(one))
