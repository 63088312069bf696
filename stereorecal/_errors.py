"""The exceptions and the warnings of stereorecal."""


class InputError(ValueError):
    """Data or options of the caller cannot be used; the message is one sentence that says what to do.

    The command line turns it into exit code 2.
    """


class UnsupportedModelError(InputError):
    """A model of a lens that is not known (omnidirectional, equirectangular, ...), or coefficients that are not its."""


class NeedNotMet(InputError):
    """The objective does not offer what a strategy needs; in a comparison, a SKIPPED row."""


class PluginError(RuntimeError):
    """A plug-in cannot be loaded, or crashed; the message names its distribution and version."""


class StrategyError(PluginError):
    """A strategy cannot be loaded, or crashed; the message names its distribution and version."""


class MatcherError(PluginError):
    """A matcher cannot be loaded, or crashed; the message names its distribution and version."""


class BudgetExhausted(Exception):
    """Raised by an objective whose budget is spent. A strategy lets it pass."""


class CalibrationWarning(UserWarning):
    """A calibration can be used but looks wrong; the message is one sentence.

    The command line prints it as a line and goes on.
    """


class PairingWarning(UserWarning):
    """Images are paired that may not correspond; the message is one sentence.

    The command line prints it as a line and goes on.
    """
