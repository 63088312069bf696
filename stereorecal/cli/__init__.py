"""The command line."""

from stereorecal.cli._main import main as main
