"""What a strategy may ask of an objective beyond values."""

import enum


class Need(enum.Enum):
    """What a strategy asks of an objective."""

    HOST = "values on the host: `objective.value` and `objective.batch` (every objective has them)"
    SMOOTH = "a differentiable score: `objective.traced.soft_count`"
    RESIDUALS = "least-squares residuals: `objective.traced.residuals`"
    IMAGES = "the images themselves: `objective.images`"
