"""What only some people need is an extra of the distribution."""

from collections.abc import Iterator
from contextlib import contextmanager

from stereorecal._errors import InputError


@contextmanager
def extra(name: str, purpose: str) -> Iterator[None]:
    """Around imports of what the extra `name` installs.

    Raises:
        InputError: if it is not installed; says the install line.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise InputError(
            f"{purpose} needs {error.name}, which is not installed; run: pip install 'stereorecal[{name}]'"
        ) from error
