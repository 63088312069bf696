"""The command line."""

from stereorecal.cli._commands import options_of as options_of, parser as parser
from stereorecal.cli._main import main as main
