"""Helpers of the library's own commands, for commands of plug-ins."""

from stereorecal._errors import checked_choice as checked_choice, existing_folder as existing_folder, extra as extra
from stereorecal._run_all import Progress as Progress, run_all as run_all
from stereorecal._version import versions as versions
from stereorecal.cli._signals import hold as hold
