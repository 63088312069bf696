"""The types of arguments and answers are checked while tests run."""

import inspect

import numpy as np
import pytest
from jaxtyping import TypeCheckError

from stereorecal.geometry import rotation_from_vector
from stereorecal.synthetic import render


def test_a_wrong_shape_is_found():
    with pytest.raises(TypeCheckError, match="rotation_from_vector"):
        rotation_from_vector(np.zeros(4))


def test_functions_within_functions_are_left_alone():
    """Or their checks would be made anew at each call of the outer one."""
    outer = inspect.unwrap(render)
    assert outer is not render  # it is checked itself
    assert "photograph" in outer.__code__.co_varnames + outer.__code__.co_cellvars
    assert "jaxtyping" not in outer.__code__.co_names
