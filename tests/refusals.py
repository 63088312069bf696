"""What is refused: in one sentence that says what to do."""

from collections.abc import Callable
from typing import Any

import pytest

from stereorecal import InputError


def refused(call: Callable[[], Any], *words: str, kind: type[InputError] = InputError) -> None:
    """The call raises an error of this kind itself, in one sentence, in which these words stand."""
    with pytest.raises(InputError) as error:
        call()
    message = str(error.value)
    assert type(error.value) is kind, message
    assert "\n" not in message
    assert message.endswith((".", "?")), message
    for word in words:
        assert word in message
