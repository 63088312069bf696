"""Strategies as options name them."""

from stereorecal._errors import InputError
from stereorecal.strategies import check_installed, strategies

NONE_INSTALLED = (
    "no strategy is installed; run: pip install 'stereorecal[default]' (in a clone: pip install -e plugins/compass)"
)


def strategy_names(text: str) -> list[str]:
    """ "a,b" or "all".

    Raises:
        InputError: if there is none, or one is not installed.
    """
    names = list(strategies()) if text == "all" else [n for n in (n.strip() for n in text.split(",")) if n]
    if not names:
        raise InputError(NONE_INSTALLED if text == "all" else "--strategies names none; give names or all.")
    for name in names:
        check_installed(name)
    return list(dict.fromkeys(names))
