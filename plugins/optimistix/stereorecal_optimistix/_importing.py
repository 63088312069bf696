"""What a run needs is imported by the first run, not with the strategies: whoever lists them does not wait for it."""

from collections.abc import Iterator
from contextlib import contextmanager

from stereorecal.strategies import AbstractStrategy, StrategyError, name_of, origin_of


@contextmanager
def importing(strategy: AbstractStrategy) -> Iterator[None]:
    """Around imports; raises StrategyError, with a sentence, if what is imported is missing or broken."""
    try:
        yield
    except Exception as error:
        raise StrategyError(
            f"strategy {name_of(strategy)} ({origin_of(strategy)}) cannot import what it needs ({error!r}); "
            "reinstall stereorecal-optimistix and its dependencies, or choose another strategy."
        ) from error
