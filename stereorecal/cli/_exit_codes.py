"""The exit codes of every command."""

from stereorecal.cli._signals import INTERRUPTED as INTERRUPTED

REPAIR, BAD_INPUT, FAILURE, CANNOT_TELL, WRONG_INPUT = 1, 2, 3, 4, 5
