"""A drive with a knock, rendered and ridden once."""

from pathlib import Path

import pytest
from rides import AFTER, BEFORE, Ride

from stereorecal.online import Config, Stepped, run
from stereorecal.synthetic import Knock, photographs, plan_drive


@pytest.fixture(scope="session")
def ride(tmp_path_factory: pytest.TempPathFactory) -> Ride:
    folder: Path = tmp_path_factory.mktemp("drives")
    knock = Knock(BEFORE, (0.5, 0.0, 0.0))
    drive = plan_drive("harbour", 2, BEFORE + AFTER, knocks=(knock,), weather=False)
    return Ride(drive.rig, drive.truth(len(drive) - 1), list(photographs(drive, folder=folder)))


@pytest.fixture(scope="session")
def ridden(ride: Ride) -> list[Stepped]:
    """All steps of the ride."""
    return list(run(ride.rig, ride.pairs, Config()))
