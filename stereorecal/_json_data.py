"""Values as JSON can hold them."""

import math
from typing import Any

import numpy as np


def json_data(value: Any) -> Any:
    """`value` with lists for tuples and arrays, text for keys, and None for numbers that are not finite."""
    if isinstance(value, dict):
        return {str(key): json_data(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_data(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return json_data(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
