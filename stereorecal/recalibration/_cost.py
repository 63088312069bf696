"""What a repair cost. One unit: one matcher run on one full-size frame (a candidate at scale s over k frames: k s²)."""

from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Cost:
    """Units, by what they were spent on.

    Attributes:
        survey: coarse matches that find a start and the disparity range.
        starts: a look at the images through the initial calibration, and counts that choose between starts.
        search: what strategies asked; with `correspondences`, what a budget pays for.
        correspondences: matches that found correspondences.
        judging: counts that nominations and the end of the schedule were judged by, and matches at vertical offsets.
    """

    survey: float = 0.0
    starts: float = 0.0
    search: float = 0.0
    correspondences: float = 0.0
    judging: float = 0.0

    @property
    def total(self) -> float:
        """All of it."""
        return sum(getattr(self, part.name) for part in fields(self))

    @property
    def budgeted(self) -> float:
        """What a budget pays for: search and correspondences."""
        return self.search + self.correspondences
