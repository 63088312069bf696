"""Validation of the options of all strategies here."""

from dataclasses import fields

import numpy as np

from stereorecal.strategies import AbstractStrategy

_WIDTH_OF_THE_BOX = 2.0


def check_options(strategy: AbstractStrategy) -> None:
    """Raises ValueError unless every option is a positive number, `steps` an integer and `step` fits the box."""
    options = {field.name: getattr(strategy, field.name) for field in fields(strategy)}
    for name, value in options.items():
        if not 0.0 < value < np.inf:
            raise ValueError(f"need {name} > 0, got {value}")
    if options["steps"] != int(options["steps"]):
        raise ValueError(f"need a whole number of steps, got {options['steps']}")
    if options.get("step", 0.0) > _WIDTH_OF_THE_BOX:
        raise ValueError(f"need step <= {_WIDTH_OF_THE_BOX:g}, the width of the box, got {options['step']}")
