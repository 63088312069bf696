"""Scoring a part of the rows: bands of equal height, each with a view of its own."""

from dataclasses import replace

import numpy as np

from stereorecal._errors import InputError
from stereorecal.scoring._prepare import ScoringData

_ROWS = 32  # of a band: its border rows see less than a window


def bands(data: ScoringData, share: float) -> tuple[ScoringData, ...]:
    """Bands of 32 rows, evenly spread over the view, that make up about `share` of it; at 1, the view itself.

    Scores of the bands add up. Pixels between them are never rectified.

    Raises:
        InputError: if the share is not within (0, 1].
    """
    if not 0.0 < share <= 1.0:
        raise InputError(f"rows is {share}; give the share of the rows that are scored, within (0, 1].")
    width, height = data.view.size
    number = max(1, round(share * height / _ROWS))
    if number * _ROWS >= height:
        return (data,)
    firsts = np.round((np.arange(number) + 0.5) * height / number - _ROWS / 2)
    views = (replace(data.view, size=(width, _ROWS), centre_row=data.view.centre_row - np.float32(f)) for f in firsts)
    return tuple(replace(data, view=view) for view in views)
