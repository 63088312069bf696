"""How the cases of a judge are drawn."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Draws:
    """How cases are drawn.

    Attributes:
        number: of each scene, and moments of a walk; rigs of folders are judged as they are stored as well.
        seed: the same seed, the same cases.
        degrees, baseline_fraction: the largest drift of each angle, and of y and z.
        frames: pairs of a rendered scene.
        rides: rendered drives.
        moving: pairs that are given of a drive.
        walk: pairs of a walk.
        kinds: of rendered scenes.
        corners, square: of the boards of folders: corners inside, and the side of a square [m].
    """

    number: int = 2
    seed: int = 0
    degrees: float = 0.5
    baseline_fraction: float = 0.01
    frames: int = 1
    rides: int = 2
    moving: int = 6
    walk: int = 100
    kinds: tuple[str, ...] = ("harbour", "street")
    corners: tuple[int, int] = (9, 6)
    square: float | None = None

    @property
    def drift(self) -> tuple[int, float, float]:
        """Seed and sizes, as recipes have them."""
        return self.seed, self.degrees, self.baseline_fraction

    @property
    def of_folders(self) -> tuple[int | None, ...]:
        """Numbers of the drifts of a rig that is stored, which is judged as it is, too."""
        return (None, *range(self.number))
