"""All commands: the parser of the command line, and the options that it makes of words.

Commands are entry points, as strategies and matchers are: a class of options that runs itself. One whose name begins
with that of another, such as "compare.judge", adds its options to that command, and may take it over.

Nothing here imports JAX, OpenCV or NumPy: help, the version and mistyped options are answered at once.
"""

from collections.abc import Sequence

from stereorecal._errors import InputError, PluginError
from stereorecal._plugins import Registry
from stereorecal._version import __version__
from stereorecal.cli._options import CommonOptions, Parser, option_group

COMMANDS = Registry[CommonOptions](
    "stereorecal.commands",
    kind="command",
    base=CommonOptions,
    error=PluginError,
    example="recalibrate",
    own={
        "recalibrate": "stereorecal.cli._repair_commands:RecalibrateOptions",
        "score": "stereorecal.cli._repair_commands:ScoreOptions",
        "monitor": "stereorecal.cli._repair_commands:MonitorOptions",
        "diff": "stereorecal.cli._calibration_commands:DiffOptions",
        "convert": "stereorecal.cli._calibration_commands:ConvertOptions",
        "compare": "stereorecal.cli._experiment_commands:CompareOptions",
        "strategies": "stereorecal.cli._experiment_commands:PluginOptions",
        "matchers": "stereorecal.cli._experiment_commands:PluginOptions",
    },
)


def parser(words: Sequence[str] = ()) -> Parser:
    """The parser of the command line.

    Args:
        words: if commands are among them, it knows no others, and reads the options of no others.
    """
    made = Parser(
        prog="stereorecal",
        usage="%(prog)s COMMAND [options]",
        description="Repair the calibration of a stereo rig from ordinary images.",
        epilog="COMMAND --help lists the options of a command.",
    )
    made.add_argument("--version", action="version", version=f"stereorecal {__version__}")
    made.add_options(CommonOptions)  # which may stand before the command or after it
    commands = made.add_subparsers(title="commands", required=True, metavar="COMMAND", dest="command", prog=made.prog)
    names = COMMANDS.names()
    verbs = [name for name in (*COMMANDS.own, *names) if "." not in name]  # its own first
    for verb in dict.fromkeys([verb for verb in verbs if verb in words] or verbs):
        try:
            parts = [COMMANDS.find(name).cls for name in (*(n for n in names if n.startswith(f"{verb}.")), verb)]
        except (InputError, PluginError) as error:
            if verb in words:
                raise
            commands.add_parser(verb, help=str(error).replace("%", "%%"))
            continue
        kind = parts[-1]
        if len(parts) > 1:
            kind = option_group(type(kind.__name__, tuple(parts), {"__doc__": kind.__doc__}))
        added = commands.add_parser(verb, help=kind.summary)
        added.add_command(kind)
        added.set_defaults(kind=kind, parser=added)
    return made


def options_of(words: Sequence[str]) -> CommonOptions:
    """The options of the command that these words name.

    Raises:
        SystemExit: of --help and --version; and with 2, once it is said, if the words make no sense.
        InputError, PluginError: as of `parser`.
    """
    parsed = vars(parser(words).parse_args(words))
    verb, kind = parsed.pop("command"), parsed.pop("kind")
    used: Parser = parsed.pop("parser")
    values = {name: tuple(value) if isinstance(value, list) else value for name, value in parsed.items()}
    try:
        return kind(verb=verb, words=tuple(words), **values)
    except InputError as error:
        return used.error(str(error))
