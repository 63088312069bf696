"""The pure functions, and what their first and second calls cost. Prints one table.

    python tests/benchmarks/pure.py [--size WIDTHxHEIGHT] [--calls N]

Each is called as users call it: a jitted function is made once, anything else is made anew (a new lambda) at every
call. In a cell: the first call in seconds (it compiles), a later one in milliseconds, and how many of these are spent
outside the compiled program: the median difference to calls of `lower().compile()`, in turn with it. That does not
depend on the images, and is measured on small ones, beside which noise would drown it. At the end: the worst of these,
and how often second calls traced or compiled.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from tables import command_line, show, table_of

import stereorecal as sr

CANDIDATES = 8
WAYS = ("plain", "jit", "vmap, 8", "jit of vmap, 8", "grad", "jit of grad", "jacfwd", "jit of jacfwd")
NO_SLOPE = ("grad", "jit of grad", "jacfwd", "jit of jacfwd")
LIMIT = 5.0  # ms outside the compiled program
SMALL = (32, 24)
_EVENTS = ("/jax/core/compile/jaxpr_trace_duration", "/jax/core/compile/backend_compile_duration")


def ways_of(function: Callable, of_rows: bool) -> dict[str, tuple[Callable[[], Callable], bool]]:
    """How to make what is called, by name; and whether it takes eight candidates."""
    jitted = jax.jit(function)
    together = jax.jit(jax.vmap(function))
    cost = jax.jit(lambda rows: jnp.sum(rows**2))
    scalar = (lambda e: cost(function(e))) if of_rows else function
    gradient, jacobian = jax.jit(jax.grad(scalar)), jax.jit(jax.jacfwd(function))
    return {
        "plain": (lambda: lambda e: function(e), False),
        "jit": (lambda: jitted, False),
        "vmap, 8": (lambda: jax.vmap(lambda e: function(e)), True),
        "jit of vmap, 8": (lambda: together, True),
        "grad": (lambda: jax.grad(lambda e: scalar(e)), False),
        "jit of grad": (lambda: gradient, False),
        "jacfwd": (lambda: jax.jacfwd(lambda e: function(e)), False),
        "jit of jacfwd": (lambda: jacobian, False),
    }


def once(function: Callable, argument: jax.Array) -> float:
    """Milliseconds of one call."""
    began = time.perf_counter()
    jax.block_until_ready(function(argument))
    return 1e3 * (time.perf_counter() - began)


def first_and_later(make: Callable[[], Callable], argument: jax.Array, calls: int, events: list[str]):
    """Milliseconds of the first call and of later ones, and how often the second traced or compiled."""
    first = once(make(), argument)
    events.clear()
    later = [once(make(), argument)]
    recompiled = len(events)
    later += [once(make(), argument) for _ in range(calls)]
    return first, float(np.median(later)), recompiled


def outside(make: Callable[[], Callable], argument: jax.Array, calls: int) -> float:
    """Milliseconds of a later call beyond those of the compiled program alone."""
    program = jax.jit(make()).lower(argument).compile()
    once(make(), argument), once(program, argument)
    return float(np.median([once(make(), argument) - once(program, argument) for _ in range(calls)]))


@dataclass(frozen=True)
class Given:
    """What the functions are called with."""

    functions: dict[str, Callable]
    at: jax.Array
    several: jax.Array


def given(size: tuple[int, int], matcher: sr.SAD) -> Given:
    """A rendered scene of a size."""
    scene = sr.synthetic.render("harbour", 0, rig=sr.synthetic.default_rig().resized(size))
    data, at = sr.prepare(scene.rig, scene.pairs), jnp.asarray(scene.rig.extrinsics, jnp.float32)
    steps = 1e-3 * np.random.default_rng(0).uniform(-1, 1, (CANDIDATES, 6))
    found = jax.block_until_ready(sr.correspondences(data, at, matcher))
    functions = {
        "count": lambda e: sr.count(data, e, matcher),
        "soft_count": lambda e: sr.soft_count(data, e, matcher),
        "correspondences": lambda e: sr.correspondences(data, e, matcher),
        "row_differences": lambda e: sr.row_differences(found, e),
    }
    return Given(functions, at, at + jnp.asarray(steps, jnp.float32))


def main() -> None:
    """Measure, print."""
    parser = command_line(__doc__)
    parser.add_argument("--size", default="320x240")
    parser.add_argument("--calls", type=int, default=20)
    options = parser.parse_args()
    events: list[str] = []

    def heard(name: str, seconds: float, **_: object) -> None:
        if name in _EVENTS:
            events.append(name)

    jax.monitoring.register_event_duration_secs_listener(heard)
    width, height = map(int, options.size.split("x"))
    large, small = given((width, height), sr.SAD(num_disparities=48)), given(SMALL, sr.SAD(num_disparities=8))
    jax.clear_caches()  # or the first call of correspondences would have been that of `given`
    smooth = ("soft_count", "row_differences")
    title = f"{options.size}: first call, second call, and ms of it outside the compiled program"
    shown = table_of(" | ".join(("function", *WAYS)), title=title)
    worst = recompiled = 0.0
    for name in large.functions:
        cells = []
        ways, on_small = (ways_of(g.functions[name], name == "row_differences") for g in (large, small))
        for way, (make, batch) in ways.items():
            if way in NO_SLOPE and name not in smooth:
                cells.append("-")
                continue
            arguments = [g.several if batch else g.at for g in (large, small)]
            first, later, again = first_and_later(make, arguments[0], options.calls, events)
            beside = outside(on_small[way][0], arguments[1], options.calls)
            cells.append(f"{first / 1e3:.1f} s, {later:.1f} ms, {beside:+.2f}")
            print(f"{name:16} {way:15} {cells[-1]}", flush=True)
            worst, recompiled = max(worst, beside), recompiled + again
        shown.add_row(name, *cells)
    show(shown)
    print(f"at most {worst:.2f} ms outside a compiled program (limit {LIMIT:.0f} ms)")
    print(f"second calls traced or compiled {recompiled:.0f} times")
    raise SystemExit(worst > LIMIT or recompiled > 0)


if __name__ == "__main__":
    main()
