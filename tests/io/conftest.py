"""How a folder that is no scene is refused."""

from collections.abc import Callable
from pathlib import Path

import pytest

from stereorecal._errors import InputError
from stereorecal.io import load_scene


@pytest.fixture(scope="session")
def refused() -> Callable[..., None]:
    """refused(folder, words, kind, about): the folder is not read as a scene, and one sentence says why."""

    def check(folder: Path, words: str, kind: type = InputError, about: str = "calib.json") -> None:
        with pytest.raises(InputError, match=words) as error:
            load_scene(folder)
        message = str(error.value)
        assert type(error.value) is kind
        assert about in message
        assert "\n" not in message
        assert message.endswith((".", ").")), message

    return check
