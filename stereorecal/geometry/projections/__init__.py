"""Projections of views: how directions become columns and rows, and disparities distances. One module each."""

from stereorecal.geometry.projections._projection import Projection as Projection
from stereorecal.geometry.projections._projections import NAMES as NAMES, projection as projection
