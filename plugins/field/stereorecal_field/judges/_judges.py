"""The judges by name, and the cases that each has."""

from stereorecal import InputError
from stereorecal.cli import checked_choice
from stereorecal_field.judges._board_judge import board_recipes
from stereorecal_field.judges._case import AbstractRecipe
from stereorecal_field.judges._draws import Draws
from stereorecal_field.judges._lidar_judge import lidar_recipes
from stereorecal_field.judges._motion_judge import motion_recipes
from stereorecal_field.judges._product_judge import product_recipes
from stereorecal_field.judges._rendered_judge import rendered_recipes
from stereorecal_field.judges._simulated_judge import simulated_recipes
from stereorecal_field.judges._walk_judge import walk_recipes

_RENDERED = {  # need no folder; `--preset field` has these
    "rendered": rendered_recipes,
    "simulated": simulated_recipes,
    "motion": motion_recipes,  # may have a folder
    "walk": walk_recipes,
}
_OF_FOLDERS = {"lidar": lidar_recipes, "boards": board_recipes, "product": product_recipes}
RENDERED = tuple(_RENDERED)
JUDGES = (*RENDERED, *_OF_FOLDERS)


def recipes_of(text: str, draws: Draws) -> tuple[AbstractRecipe, ...]:
    """The cases of a judge.

    Args:
        text: NAME, or NAME=FOLDER: its name, and the folder that it looks into; `rendered=KIND`, `simulated=KIND` name
            a kind of scene instead.

    Raises:
        InputError: if there is no such judge, or its folder does not hold what it needs.
    """
    name, _, place = text.partition("=")
    name = checked_choice(name.strip(), list(JUDGES), "judge")
    if name in _OF_FOLDERS and not place:
        raise InputError(f"judge {name} needs a folder; give {name}=FOLDER (docs/data.md says what is in it).")
    return (_RENDERED | _OF_FOLDERS)[name](place, draws)
