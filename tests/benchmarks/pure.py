"""The pure functions, and what their first and later calls cost. Prints one table.

    python tests/benchmarks/pure.py

Each is called as users call it: a jitted function is made once, anything else is made anew (a new lambda) at every
call. In a cell: the first call in seconds (it compiles), a later one in milliseconds. (That later calls compile
nothing: tests/scoring/test_compiled_once.py.)
"""

import time
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from tables import show, table_of

import stereorecal as sr

CANDIDATES, CALLS, SIZE = 8, 20, (320, 240)
MATCHER = sr.SAD(num_disparities=48)
SMOOTH = ("soft_count", "row_differences")


def ways_of(function: Callable, smooth: bool, of_rows: bool) -> dict[str, tuple[Callable[[], Callable], bool]]:
    """How to make what is called, by name; and whether it takes eight candidates."""
    jitted, together = jax.jit(function), jax.jit(jax.vmap(function))
    ways = {
        "plain": (lambda: lambda e: function(e), False),
        "jit": (lambda: jitted, False),
        "vmap, 8": (lambda: jax.vmap(lambda e: function(e)), True),
        "jit of vmap, 8": (lambda: together, True),
    }
    if not smooth:
        return ways
    scalar = (lambda e: jnp.sum(function(e) ** 2)) if of_rows else function
    gradient, jacobian = jax.jit(jax.grad(scalar)), jax.jit(jax.jacfwd(function))
    return ways | {
        "grad": (lambda: jax.grad(lambda e: scalar(e)), False),
        "jit of grad": (lambda: gradient, False),
        "jacfwd": (lambda: jax.jacfwd(lambda e: function(e)), False),
        "jit of jacfwd": (lambda: jacobian, False),
    }


def seconds(function: Callable, argument: jax.Array) -> float:
    """Of one call."""
    began = time.perf_counter()
    jax.block_until_ready(function(argument))
    return time.perf_counter() - began


def main() -> None:
    """Measure, print."""
    scene = sr.synthetic.render("harbour", 0, rig=sr.synthetic.default_rig().resized(SIZE))
    data, at = sr.prepare(scene.rig, scene.pairs), jnp.asarray(scene.rig.extrinsics, jnp.float32)
    several = at + jnp.asarray(1e-3 * np.random.default_rng(0).uniform(-1, 1, (CANDIDATES, 6)), jnp.float32)
    found = jax.block_until_ready(sr.correspondences(data, at, MATCHER))
    jax.clear_caches()  # or the first call of correspondences would have been this one
    functions = {
        "count": lambda e: sr.count(data, e, MATCHER),
        "soft_count": lambda e: sr.soft_count(data, e, MATCHER),
        "correspondences": lambda e: sr.correspondences(data, e, MATCHER),
        "row_differences": lambda e: sr.row_differences(found, e),
    }
    shown = table_of("function | way | first call | a later one", title="{}x{}".format(*SIZE), left=2)
    for name, function in functions.items():
        for way, (make, batch) in ways_of(function, name in SMOOTH, name == "row_differences").items():
            argument = several if batch else at
            first, *later = (seconds(make(), argument) for _ in range(1 + CALLS))
            shown.add_row(name, way, f"{first:.1f} s", f"{1e3 * np.median(later):.1f} ms")
    show(shown)


if __name__ == "__main__":
    main()
