"""All commands: the parser of the command line, and the options that it makes of words.

Nothing here imports JAX, OpenCV or NumPy: help, the version and mistyped options are answered at once.
"""

from collections.abc import Sequence
from importlib import import_module

from stereorecal._errors import InputError
from stereorecal._version import __version__
from stereorecal.cli._options import CommonOptions, Parser

_COMMANDS = {  # where the options of each stand, and what it does
    "recalibrate": ("_repair_commands.RecalibrateOptions", "repair the calibration of a rig"),
    "score": ("_repair_commands.ScoreOptions", "check a calibration against images"),
    "monitor": ("_repair_commands.MonitorOptions", "watch a rig over a recording, and repair it"),
    "diff": ("_calibration_commands.DiffOptions", "what one calibration changes against another"),
    "convert": ("_calibration_commands.ConvertOptions", "write a calibration in another format"),
    "compare": ("_experiment_commands.CompareOptions", "decalibrate rigs, and compare how strategies repair them"),
    "reproduce": ("_experiment_commands.ReproduceOptions", "run the paper's experiments"),
    "strategies": ("_plugin_commands.PluginOptions", "list the installed strategies, or check one"),
    "matchers": ("_plugin_commands.PluginOptions", "list the installed matchers, or check one"),
}


def parser(verbs: Sequence[str] = tuple(_COMMANDS)) -> Parser:
    """The parser of the command line.

    Args:
        verbs: the commands whose options it knows; those of the others are not even read.
    """
    made = Parser(
        prog="stereorecal",
        usage="%(prog)s COMMAND [options]",
        description="Repair the extrinsic calibration of a stereo rig from ordinary images.",
        epilog="COMMAND --help lists the options of a command.",
    )
    made.add_argument("--version", action="version", version=f"stereorecal {__version__}")
    made.add_options(CommonOptions)  # which may stand before the command or after it
    commands = made.add_subparsers(title="commands", required=True, metavar="COMMAND", dest="command", prog=made.prog)
    for verb, (place, summary) in _COMMANDS.items():
        added = commands.add_parser(verb, help=summary)
        if verb in verbs:
            module, _, name = place.partition(".")
            kind = getattr(import_module(f"stereorecal.cli.{module}"), name)
            added.add_command(kind)
            added.set_defaults(kind=kind, parser=added)
    return made


def options_of(words: Sequence[str]) -> CommonOptions:
    """The options of the command that these words name.

    Raises:
        SystemExit: of --help and --version; and with 2, once it is said, if the words make no sense.
    """
    parsed = vars(parser(words).parse_args(words))
    verb, kind = parsed.pop("command"), parsed.pop("kind")
    used: Parser = parsed.pop("parser")
    values = {name: tuple(value) if isinstance(value, list) else value for name, value in parsed.items()}
    try:
        return kind(verb=verb, words=tuple(words), **values)
    except InputError as error:
        return used.error(str(error))
