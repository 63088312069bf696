"""What a strategy may need of an objective."""

import enum


class Need(enum.Enum):
    """What a strategy needs of an objective; the value says where it finds it."""

    HOST = "values on the host: `objective.value` and `objective.batch` (every objective has them)"
    SMOOTH = "a differentiable score: `objective.traced.soft_count`"
    RESIDUALS = "least-squares residuals: `objective.traced.residuals`"
    IMAGES = "the images themselves: `objective.images`"
