"""What a process has that runs tests, and does not only hand them out: checked types, and what many files share."""

import pytest
from fixtures import (
    data_dir as data_dir,
    install as install,
    moody as moody,
    once as once,
    scene as scene,
    settings_of_jax as settings_of_jax,
)
from hypothesis import settings
from typechecking import pytest_runtest_setup as pytest_runtest_setup, unchecked as unchecked

settings.register_profile("stereorecal", derandomize=True, deadline=None)
settings.load_profile("stereorecal")
settings.register_profile("quick", settings.default, max_examples=20)  # what takes long has a share of these


def pytest_configure(config: pytest.Config) -> None:
    """Fewer examples where what is slow is left out."""
    if not config.option.slow:
        settings.load_profile("quick")
