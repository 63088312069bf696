"""What commands use of the library's own helpers, for those that come from plug-ins."""

from stereorecal._choices import checked_choice as checked_choice
from stereorecal._environment import versions as versions
from stereorecal._existing_paths import existing_folder as existing_folder
from stereorecal._extras import extra as extra
from stereorecal._run_all import Progress as Progress, run_all as run_all
from stereorecal._signals import hold as hold
