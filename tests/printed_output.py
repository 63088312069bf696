"""What a page says that its code prints, compared with what it does print."""

import re

_NUMBER = re.compile(r"[+-]?\d+(?:[ \u202f]\d{3}\b)*(?:\.\d*)?(?:e[+-]?\d+)?")
_TOKEN = re.compile(rf"{_NUMBER.pattern}|\w+|[^\w\s]")
_SECONDS = re.compile(r"\d+(?:\.\d+)?(?= ?s\b)")
_START, _END = "\x02", "\x03"
_APART, _SHARE = 0.5, 0.25


def agrees(shown: str, printed: str) -> bool:
    """Whether a page shows what was printed.

    "…" stands for anything, the width of spaces does not matter, seconds are free, and numbers hold to a quarter or
    to a half: programs that are compiled otherwise round otherwise, and a search that doubts ends elsewhere.
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
    share = 0.0 if shown.isdigit() and one < 10 else _SHARE  # few of something, a unit, a name
    return abs(one - other) <= max(_APART, share * abs(one))
