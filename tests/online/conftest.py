"""A drive with a knock, rendered and ridden once."""

from collections.abc import Callable
from typing import Any

import pytest
from rides import AFTER, Ride, ride_of

from stereorecal.online import Config, Stepped, run


@pytest.fixture(scope="session")
def ride(once: Callable[..., Any]) -> Ride:
    return once("ride", lambda: ride_of(0.5, AFTER))


@pytest.fixture(scope="session")
def ridden(once: Callable[..., Any], ride: Ride) -> list[Stepped]:
    """All steps of the ride."""
    return once("ridden", lambda: list(run(ride.rig, ride.pairs, Config())))
