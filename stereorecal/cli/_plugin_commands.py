"""The options of the commands about plug-ins."""

from importlib import import_module
from typing import Literal

from stereorecal._errors import InputError
from stereorecal.cli._options import CommonOptions, argument, option_group


@option_group
class PluginOptions(CommonOptions):
    """List what is installed, or run the conformance kit on one."""

    summary = "list those that are installed, or check one"
    module = "stereorecal.cli._installed_plugins"
    forms = ("[list]", "check NAME")
    action: Literal["list", "check"] = argument("list what is installed, or run the conformance kit on one", "list")
    name: str | None = argument("the one to be checked", None, metavar="NAME")

    def __post_init__(self) -> None:
        if self.action == "check" and self.name is None:
            raise InputError(f"{self.verb} check needs a name; {self.verb} list shows those that are installed")
        if self.action == "list" and self.name is not None:
            raise InputError(f"unrecognized arguments: {self.name}")

    def check(self) -> None:
        if self.verb == "strategies" and self.name is not None:
            import_module("stereorecal.strategies").check_installed(self.name)
