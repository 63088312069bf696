"""The command line."""

from stereorecal.cli._exit_codes import INTERRUPTED as INTERRUPTED
from stereorecal.cli._main import main as main
