"""Plain data, as JSON takes it."""

import math
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """`value` with lists for tuples and arrays, text for keys, and None for numbers that are not finite."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
