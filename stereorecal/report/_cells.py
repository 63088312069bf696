"""Numbers as cells of a table; what is missing is a dash."""


def number(value: float | None, digits: int) -> str:
    """With a fixed number of digits."""
    return "-" if value is None else f"{value:.{digits}f}"


def count(value: float | None) -> str:
    """A whole number, in groups of three digits."""
    return "-" if value is None else f"{value:,.0f}".replace(",", " ")


def percent(share: float | None) -> str:
    """A share as percent."""
    return "-" if share is None else f"{100 * share:.0f} %"
