"""Options as they are declared, and what the command line makes of them."""

from typing import ClassVar, Literal

import pytest

from stereorecal.cli._options import CommonOptions, Parser, argument, option, option_group


@option_group
class Lens:
    title = "of the lens"
    focus: float | None = option("metres to the object, 5 % more or less")


@option_group
class Shoot(Lens, CommonOptions):
    """Take
    pictures.

    Exit code: 0 done."""

    forms = ("PLACE [NAME …]", "--files FILE")
    module: ClassVar[str | None] = "_camera"
    place: str = argument("where", metavar="PLACE")
    names: tuple[str, ...] = argument("of whom", ("all",), metavar="NAME")
    pictures: int = option("how many", 3, metavar="N")
    mode: Literal["day", "night"] = option("when", "day")
    sides: tuple[str, str] | None = option("both", metavar=("LEFT", "RIGHT"))
    files: tuple[str, ...] | None = option("some", metavar="FILE")
    tag: tuple[str, ...] = option("one more", (), metavar="TAG")
    dry_run: bool = option("take none", False)
    first: int = option("to begin with", 0, flag="--from", metavar="N")


@pytest.fixture
def parser() -> Parser:
    made = Parser(prog="shoot")
    made.add_command(Shoot)
    return made


def options(parser: Parser, words: str) -> Shoot:
    return Shoot(**vars(parser.parse_args(words.split())))


def test_what_is_not_given_has_the_default_of_its_field(parser: Parser):
    found = options(parser, "here")
    assert (found.place, found.names, found.pictures, found.mode) == ("here", ("all",), 3, "day")
    assert (found.sides, found.files, found.tag, found.focus) == (None, None, (), None)
    assert (found.dry_run, found.first, found.traceback) == (False, 0, False)


def test_values_have_the_types_of_their_fields(parser: Parser):
    words = "here ann bo --pictures 2 --mode night --sides l r --files a b c --tag x --tag y --dry-run --from 4"
    found = options(parser, f"{words} --focus 2.5 --traceback")
    assert (found.place, list(found.names), found.pictures, found.mode) == ("here", ["ann", "bo"], 2, "night")
    assert [list(some or ()) for some in (found.sides, found.files, found.tag)] == [["l", "r"], list("abc"), ["x", "y"]]
    assert (found.dry_run, found.first, found.focus, found.traceback) == (True, 4, 2.5, True)


def test_help_tells_forms_and_defaults_once_and_groups_under_their_title(parser: Parser):
    usage, about, arguments, titled, text, end = parser.format_help().split("\n\n")
    assert usage == "usage: shoot [options] PLACE [NAME …]\n       shoot [options] --files FILE"
    assert about == "Take pictures."
    assert arguments.startswith("arguments:\n")
    assert titled.startswith("of the lens:\n")
    assert text.startswith("running:\n")
    assert "how many (default: 3)" in text
    assert "when (default: day)" in text
    assert "to begin with (default: 0)" in text
    assert text.count("default") == 3
    assert "metres to the object, 5 % more or less" in titled
    assert text.index("--pictures N") < text.index("--files FILE …") < text.index("--traceback")
    assert end == "Exit code: 0 done.\n"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "the following arguments are required: PLACE"),
        ("here --mode nigth", "unknown --mode 'nigth' (did you mean night?)"),
        ("here --mode 7", "unknown --mode '7' (choose one of: day, night)"),
        ("here --sides l", "argument --sides: expected 2 arguments"),
        ("here --pictures some", "argument --pictures: invalid int value: 'some'"),
        ("here --picturse 2", "unrecognized arguments: --picturse 2 (did you mean --pictures?)"),
    ],
)
def test_one_sentence_says_what_is_wrong(parser: Parser, words: str, said: str, capsys):
    with pytest.raises(SystemExit) as end:
        parser.parse_args(words.split())
    assert end.value.code == 2
    assert capsys.readouterr().err == f"stereorecal: {said}; see shoot --help\n"
