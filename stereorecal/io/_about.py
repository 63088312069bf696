"""Says which file an error is about."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from stereorecal._errors import InputError


@contextmanager
def about(subject: Any) -> Iterator[None]:
    """Put `subject` in front of the message of any InputError raised inside; its class stays."""
    try:
        yield
    except InputError as error:
        raise type(error)(f"{subject}: {error}") from error
