"""Names that were replaced before the first release: asking for one says what its new name is."""

from collections.abc import Callable, Mapping
from typing import NoReturn


def renamed(package: str, names: Mapping[str, str]) -> Callable[[str], NoReturn]:
    """The `__getattr__` of a package.

    Args:
        names: old name to new name.

    Raises:
        ImportError: for an old name, with the new one: `from package import old` would drop the message of an
            AttributeError.
        AttributeError: for a name that was never there.
    """

    def answer(name: str) -> NoReturn:
        new = names.get(name)
        if new is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        raise ImportError(f"{package}.{name} is now {package}.{new}; use that name.", name=package)

    return answer


def renamed_attributes(names: Mapping[str, str]) -> Callable[[object, str], NoReturn]:
    """The `__getattr__` of a class.

    Args:
        names: old name to new name, which may lead through other attributes.

    Raises:
        AttributeError: for an old name, with the new one; and for a name that was never there.
    """

    def answer(self: object, name: str) -> NoReturn:
        kind, new = type(self).__name__, names.get(name)
        if new is None:
            raise AttributeError(f"{kind!r} object has no attribute {name!r}")
        raise AttributeError(f"{kind}.{name} is now {kind}.{new}; use that name.")

    return answer
