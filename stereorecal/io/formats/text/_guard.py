"""Texts that parsers can be given."""

from stereorecal._errors import InputError

# Parsers call themselves at each level of nesting. Nesting is no deeper than there are opening brackets and tags, or
# items begun on one line, or than indentation fits into the text.
_MOST_OPENINGS = 2000
_LONGEST = 1 << 22  # characters; a calibration of a rig has a few thousand, and its rectifying maps some million


def check_flat(text: str) -> None:
    """Refuse, before any parser sees it, a text that is no calibration.

    Raises:
        InputError: if it is too long or may be nested too deeply.
    """
    openings = sum(text.count(bracket) for bracket in "[{<")
    items = max((line.count("- ") for line in text.splitlines()), default=0)
    if len(text) > _LONGEST or max(openings, items) > _MOST_OPENINGS:
        raise InputError("too long or too deeply nested for a calibration; check that this is the right file.")
