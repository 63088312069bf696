"""The judges by name, and the cases that each has."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stereorecal._choices import checked_choice
from stereorecal._errors import InputError
from stereorecal.comparison.judges._case import AbstractRecipe
from stereorecal.comparison.judges._drive_judges import Ride, Walk
from stereorecal.comparison.judges._folders import (
    Boards,
    Driven,
    Lidar,
    Product,
    boards_beside,
    check_boards,
    check_drive,
    check_one_rig,
    check_rigs,
    scene_folders,
    with_truth,
)
from stereorecal.comparison.judges._rendered import Rendered, Simulated
from stereorecal.synthetic import KINDS

JUDGES = ("rendered", "simulated", "motion", "walk", "lidar", "boards", "product")
_OF_FOLDERS = ("lidar", "boards", "product")  # and motion, which may have one
_TOURS = ("street", "harbour")


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


def recipes_of(asked: str, draws: Draws) -> tuple[AbstractRecipe, ...]:
    """The cases of a judge.

    Args:
        asked: NAME, or NAME=FOLDER: its name, and the folder that it looks into; `rendered=KIND`, `simulated=KIND` name
            a kind of scene instead.

    Raises:
        InputError: if there is no such judge, or its folder does not hold what it needs.
    """
    name, _, where = asked.partition("=")
    name = checked_choice(name.strip(), list(JUDGES), "judge")
    if name in _OF_FOLDERS and not where:
        raise InputError(f"judge {name} needs a folder; give {name}=FOLDER (docs/data.md says what is in it).")
    match name:
        case "rendered":
            kinds = (checked_choice(where, list(KINDS), "kind of scene"),) if where else draws.kinds
            return tuple(
                Rendered(f"{kind}-{draws.seed}", draw, *_drift(draws), kind, draws.frames)
                for kind in kinds
                for draw in range(draws.number)
            )
        case "simulated":
            kind = checked_choice(where, list(KINDS), "kind of scene") if where else draws.kinds[0]
            numbers = range(draws.number)
            return tuple(Simulated(kind, draw, *_drift(draws), kind, draws.frames) for draw in numbers)
        case "motion" if not where:
            tours = [_TOURS[draw % len(_TOURS)] for draw in range(draws.rides)]
            return tuple(Ride(tour, draw, *_drift(draws), tour, draws.moving) for draw, tour in enumerate(tours))
        case "walk":
            if where:
                raise InputError("judge walk is rendered and takes no folder; leave it out.")
            moments = _moments(draws.walk, draws.number)
            return tuple(
                Walk("street", moment, draws.seed, 0.0, 0.0, "street", draws.walk, moment) for moment in moments
            )
    return _of_folder(name, Path(where), draws)


def _of_folder(name: str, folder: Path, draws: Draws) -> tuple[AbstractRecipe, ...]:
    folders, every = scene_folders(folder), (None, *range(draws.number))
    match name:
        case "lidar":
            if not (true := with_truth(folders)):
                raise InputError(f"{folder}: no scene names a disparity_gt in its calib.json; lidar judges by it.")
            check_rigs(true)
            return tuple(Lidar(_name(one, folder), draw, *_drift(draws), str(one)) for one in true for draw in every)
        case "boards":
            check_rigs(folders)
            if draws.square is None:
                raise InputError("judge boards needs --square, the side of a square in metres, such as 0.03.")
            boards = boards_beside(folder)
            check_boards(boards, draws.corners, draws.square)
            how = str(boards), draws.corners, draws.square
            return tuple(
                Boards(_name(one, folder), draw, *_drift(draws), str(one), *how) for one in folders for draw in every
            )
        case "product":
            check_one_rig(folders)
            found = []
            for one in folders:
                others = tuple(str(other) for other in folders if other != one)
                found += [Product(_name(one, folder), draw, *_drift(draws), str(one), others) for draw in every]
            return tuple(found)
    for one in folders:
        check_drive(one)
    return tuple(
        Driven(_name(one, folder), draw, *_drift(draws), str(one), draws.moving) for one in folders for draw in every
    )


def _drift(draws: Draws) -> tuple[int, float, float]:
    return draws.seed, draws.degrees, draws.baseline_fraction


def _moments(length: int, number: int) -> Sequence[int]:
    """Evenly spread, the last pair among them."""
    return sorted({round((index + 1) * (length - 1) / number) for index in range(number)})


def _name(scene: Path, folder: Path) -> str:
    """What a scene is called: its place in the folder that was given."""
    return folder.name if scene == folder else scene.relative_to(folder).as_posix()
