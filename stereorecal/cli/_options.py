"""Options stand once, as fields of frozen dataclasses: type, default and help; the parser is made from them.

The options of a command are a dataclass that inherits groups of them, which it shares with other commands. Its
docstring describes the command, and what follows the first paragraph stands at the end of the help.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import MISSING, Field, dataclass, field
from difflib import get_close_matches
from importlib import import_module
from inspect import get_annotations
from types import NoneType, UnionType
from typing import Any, ClassVar, Literal, NoReturn, TypeVar, Union, dataclass_transform, get_args, get_origin

from stereorecal._errors import InputError
from stereorecal._plugins import install_line
from stereorecal.cli._places import Place, paths
from stereorecal.cli._signals import BAD_INPUT

_Group = TypeVar("_Group")

TWO_FILES = "the two files of a calibration are named as LEFT,RIGHT"
QUOTED = "a pattern such as 'left/*.png' must be quoted"
_ELSEWHERE = {  # what comes with distributions of their own: their folders in a clone
    "reproduce": "paper",
    **dict.fromkeys(("--judge", "--preset", "--full"), "field"),
    **dict.fromkeys(("--boards", "--board-corners"), "boards"),
}

# Headings in the help, in their order; other headings follow them, and RUNNING is the last.
WRITES = "what to write"
READS = "what to read"
PAIRS = "which pairs"
RIG = "the rig, and what may move"
DEPTH = "depth, from motion and ranges"
DECISION = "the decision"
SEARCH = "matching and search"
RUNNING = "running"
ARGUMENTS = "arguments"
_HEADINGS = (ARGUMENTS, WRITES, READS, PAIRS, RIG, DEPTH, DECISION, SEARCH)


def option(
    heading: str,
    help: str,
    default: Any = None,
    *,
    metavar: str | tuple[str, ...] | None = None,
    flag: str | None = "",
    reads: Callable[[Any, str], Any] | None = None,
    loads: str = "",
    writes: bool = False,
) -> Any:
    """A field that is an option: a bool is a switch, a Literal a choice; a tuple takes several words, or may be given
    several times if it is `()` by default.

    Args:
        heading: under which it stands in the help, such as `READS`.
        help: what `--help` says of it; the default is added where there is one, unless the text names it.
        flag: if it is no "--name-of-the-field"; None of an `argument`.
        reads: makes of the words, and the flag for its messages, what is computed with; `value_of` has that. It
            does not import JAX, nor what needs it: mistakes are refused at once.
        loads: "module:function" that does so for the name of a file.
        writes: names what the command writes; `CommonOptions.places` has it. Only where the metavar says so, "-" is
            stdout.
    """
    told = {"heading": heading, "help": help, "metavar": metavar, "flag": flag}
    return field(default=default, metadata={**told, "reads": reads, "loads": loads, "writes": writes})


def argument(heading: str, help: str, default: Any = MISSING, *, metavar: str | None = None) -> Any:
    """A field whose value is given by its place; without a default it has to be."""
    return option(heading, help, default, metavar=metavar, flag=None)


@dataclass_transform(frozen_default=True, kw_only_default=True)
def option_group(kind: type[_Group]) -> type[_Group]:
    """Make a frozen dataclass of options, without what takes time at every start and nobody uses."""
    return dataclass(frozen=True, kw_only=True, eq=False, repr=False)(kind)


@option_group
class CommonOptions:
    """Options of every command.

    Attributes:
        summary: what the command does, in the list of all commands.
        module: "module:function" that does the work and returns the exit code; `run` where only the module is named.
        forms: what a command line may consist of, beside options.
        verb: the command.
        words: the command line from which they come; a page shows it.
    """

    summary: ClassVar[str] = ""
    module: ClassVar[str] = ""
    forms: ClassVar[tuple[str, ...]] = ("",)
    verb: str = ""
    words: tuple[str, ...] = ()
    traceback: bool = option(RUNNING, "show where an error comes from", False)

    @property
    def places(self) -> list[Place]:
        """The files that are to be written."""
        written = (one for one in self.__dataclass_fields__.values() if one.metadata.get("writes"))
        named = (one for one in written if getattr(self, one.name) not in (None, "-"))
        return [Place(_flag(one), path) for one in named for path in paths(value_of(self, one.name))]

    def check_words(self) -> None:
        """Refuse words that make no sense."""
        for name, one in self.__dataclass_fields__.items():
            told = one.metadata
            if told.get("writes") and getattr(self, name) == "-" and not told["metavar"].endswith("-"):
                raise InputError(f"{_flag(one)} - has no meaning: it is written to a file; give the name of one.")
            if told.get("reads"):
                value_of(self, name)

    def check(self) -> None:
        """Refuse what can be told at once, before the modules are imported that do the work, which takes seconds.

        Raises:
            InputError: says what to do.
        """

    def run(self) -> int:
        """Do the work; returns the exit code."""
        module, _, function = self.module.partition(":")
        return getattr(import_module(module), function or "run")(self)


def value_of(options: Any, name: str, default: Any = None) -> Any:
    """What an option comes to, by its `reads` or `loads`.

    Args:
        options: a group that has it.
        default: if it was not given.

    Raises:
        InputError: if its words make no sense, or its file cannot be read.
    """
    words, found = getattr(options, name), options.__dataclass_fields__[name]
    if words is None:
        return default
    if found.metadata["loads"]:
        module, _, function = found.metadata["loads"].partition(":")
        return getattr(import_module(module), function)(words)
    reads = found.metadata["reads"]
    return words if reads is None else reads(words, _flag(found))


class _Help(argparse.HelpFormatter):
    """Help whose texts begin in one column."""

    def __init__(self, prog: str, **settings: Any) -> None:
        super().__init__(prog, max_help_position=26, **settings)
        self._action_max_length = 24  # of the widest; else it is another one in each command


class Parser(argparse.ArgumentParser):
    """A parser that says in one sentence what is wrong, with the nearest name, and exits with 2."""

    def __init__(self, **settings: Any) -> None:
        # What is not given has the default of its field. The beginning of a name is none: it would change its meaning
        # with the next option that begins alike.
        super().__init__(argument_default=argparse.SUPPRESS, formatter_class=_Help, allow_abbrev=False, **settings)

    def add_command(self, options: type[CommonOptions]) -> None:
        """Become the parser of a command."""
        forms = [f"{self.prog} [options] {form}".rstrip() for form in options.forms]
        self.usage = "\n       ".join(forms)
        self.description, _, self.epilog = (options.__doc__ or "").partition("\n\n")
        self._positionals.title, self._optionals.title = ARGUMENTS, RUNNING
        self.add_options(options)

    def add_options(self, options: type[CommonOptions]) -> None:
        """Add options under their headings, those of the command first, those that other distributions add last."""
        groups: dict[str, Any] = {RUNNING: self, ARGUMENTS: self}
        kinds = sorted(options.__mro__, key=lambda kind: not kind.__module__.startswith("stereorecal."))
        declared = dict.fromkeys(name for kind in kinds for name in get_annotations(kind))
        fields = [one for one in map(options.__dataclass_fields__.get, declared) if one is not None and one.metadata]
        for one in sorted(fields, key=_by_flag):  # the others first
            heading = one.metadata["heading"]
            if heading not in groups:
                groups[heading] = self.add_argument_group(heading)
            named = {"dest": one.name} if _by_flag(one) else {}
            groups[heading].add_argument(_flag(one), **named, **_value(one))

    def format_help(self) -> str:
        """The help, with its headings in order."""
        order = {heading: place for place, heading in enumerate(_HEADINGS)}
        self._action_groups.sort(key=lambda one: (one is self._optionals, order.get(one.title or "", len(order))))
        return super().format_help()

    def parse_known_args(self, args=None, namespace=None):  # pyright: ignore[reportIncompatibleMethodOverride]
        """What a command does not know is said by it, not by the parser of all commands."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._hint(unknown)}")
        for action in self._actions:
            value = getattr(found, action.dest, None)
            if "" in (value if isinstance(value, list | tuple) else [value]):
                what = action.option_strings[0] if action.option_strings else action.metavar or action.dest
                self.exit(BAD_INPUT, f"stereorecal: {what} is empty; give the name of a file or folder, or a value.\n")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"stereorecal: {message}; see {self.prog} --help\n")

    def _hint(self, unknown: Sequence[str]) -> str:
        known = [name for action in self._actions for name in action.option_strings]
        flag = next((word.partition("=")[0] for word in unknown if word.startswith("-")), None)
        if flag is None and "--left" in known and len(unknown) > 1:
            return f" ({QUOTED})"
        if flag is None:
            return f" ({TWO_FILES})" if "--unit" in known else ""
        if flag in _ELSEWHERE:
            return f" ({flag} comes with: {install_line(_ELSEWHERE[flag])})"
        word, names = flag.lstrip("-"), {name.lstrip("-"): name for name in known}  # dashes are alike in all of them
        takers = [one.option_strings[0] for one in self._actions if one.metavar == word.upper() and one.option_strings]
        close = takers or [names[one] for one in get_close_matches(word, names, 1)]
        return f" (did you mean {' or '.join(close)}?)" if close else ""

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        if value in _ELSEWHERE:
            raise argparse.ArgumentError(None, f"{value} is not installed; run: {install_line(_ELSEWHERE[value])}")
        close = get_close_matches(str(value), action.choices, 1)
        hint = f"did you mean {close[0]}?" if close else f"choose one of: {', '.join(action.choices)}"
        what = action.option_strings[0] if action.option_strings else action.dest
        raise argparse.ArgumentError(None, f"unknown {what} {value!r} ({hint})")


def _by_flag(found: Field[Any]) -> bool:
    return found.metadata["flag"] is not None


def _flag(found: Field[Any]) -> str:
    """What an option is called on a command line."""
    return found.metadata["flag"] or (f"--{found.name.replace('_', '-')}" if _by_flag(found) else found.name)


def _value(found: Field[Any]) -> dict[str, Any]:
    """How argparse is told of one option."""
    text, default = found.metadata["help"], found.default
    kinds = get_args(found.type) if get_origin(found.type) in (Union, UnionType) else (found.type,)
    (kind,) = (kind for kind in kinds if kind is not NoneType)
    parts, several = get_args(kind), get_origin(kind) is tuple
    if isinstance(default, str | int | float) and kind is not bool and "default" not in text:
        text = f"{text} (default: {default})"
    told: dict[str, Any] = {"help": text.replace("%", "%%")}
    if kind is bool:
        return {**told, "action": "store_true"}
    told["metavar"] = found.metadata["metavar"]
    if not _by_flag(found) and default is not MISSING:
        told |= {"nargs": "*" if several else "?", "default": default}
    elif several and default == ():
        told["action"] = "append"
    elif several:
        told["nargs"] = "+" if parts[-1] is ... else len(parts)
    if get_origin(kind) is Literal:
        told["choices"] = parts
    return told if several or "choices" in told else {**told, "type": kind}
