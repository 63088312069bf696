"""Numbers formatted as table cells; a missing value (None) is a dash."""


def number(value: float | None, digits: int) -> str:
    """The value with `digits` decimals."""
    return "-" if value is None else f"{value:.{digits}f}"


def count(value: float | None) -> str:
    """The value rounded to a whole number, its digits in groups of three."""
    return "-" if value is None else f"{value:,.0f}".replace(",", " ")


def percent(share: float | None) -> str:
    """A fraction as a whole number of percent."""
    return "-" if share is None else f"{100 * share:.0f} %"
