"""On the vehicle: how a rig stands while it drives, what knocked it, and its repair.

A `State` is all there is; `step` is a function of it and of the next pair. `run` steps through a recording, and
`MonitorProcess` steps in a process of its own, beside a capture loop.
"""

from stereorecal.online._advice import (
    Advice as Advice,
    Showing as Showing,
    Undetermined as Undetermined,
    advice as advice,
)
from stereorecal.online._config import EVENTS_SCHEMA as EVENTS_SCHEMA, Config as Config, Event as Event, Kind as Kind
from stereorecal.online._matches import BAND_EDGES as BAND_EDGES, PARTS as PARTS
from stereorecal.online._monitor_process import MonitorProcess as MonitorProcess
from stereorecal.online._reading import FAR as FAR, Reading as Reading, reading as reading
from stereorecal.online._saving import load as load, save as save
from stereorecal.online._state import State as State
from stereorecal.online._step import (
    Stepped as Stepped,
    freeze as freeze,
    init as init,
    rollback as rollback,
    run as run,
    step as step,
)
from stereorecal.online._switching import recalibrate as recalibrate
