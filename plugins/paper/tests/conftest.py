"""What these tests share."""

import pytest
from fixtures import (
    at_once as at_once,
    command as command,
    install as install,
    moody as moody,
    once as once,
    scene as scene,
)
from stereorecal_paper import _synthetic_log


@pytest.fixture
def small_synthetic_log(monkeypatch: pytest.MonkeyPatch) -> None:
    """One pair of 160x120 in each of its missions."""
    monkeypatch.setattr(_synthetic_log, "_QUICK_SIZE", (160, 120))
    monkeypatch.setattr(_synthetic_log, "_QUICK_PAIRS", 1)
