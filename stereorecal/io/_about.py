"""Error messages that name their file."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from stereorecal._errors import InputError


@contextmanager
def about(subject: Any) -> Iterator[None]:
    """Prefix the message of any InputError raised inside with `subject`, such as a path; its class is kept."""
    try:
        yield
    except InputError as error:
        raise type(error)(f"{subject}: {error}") from error
