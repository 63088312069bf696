"""A rig with a lens, and what it sees."""

from simulated_rows import chart as chart, prior as prior, rig as rig, seen as seen, steps as steps
