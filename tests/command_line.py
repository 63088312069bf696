"""The command line in this process."""

import signal
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from stereorecal.cli import main


@dataclass(frozen=True)
class Answer:
    """How a command ended and what it said."""

    code: int
    out: str
    err: str


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Callable[..., Answer]:
    """command(words...): run a command; an exit by argparse counts as a return."""
    handler = signal.getsignal(signal.SIGTERM)

    def run(*words: object) -> Answer:
        capsys.readouterr()
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = int(end.code or 0)
        finally:
            signal.signal(signal.SIGTERM, handler)
        return Answer(code, *capsys.readouterr())

    return run
