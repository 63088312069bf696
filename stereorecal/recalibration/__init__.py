"""Recalibration: schedules, the repair itself, its verdict."""

from stereorecal.recalibration._recalibrate import recalibrate as recalibrate
from stereorecal.recalibration._schedule import Schedule as Schedule, Stage as Stage
from stereorecal.recalibration._solution import Reason as Reason, Solution as Solution
