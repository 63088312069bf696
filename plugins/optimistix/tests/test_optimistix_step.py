"""Stepped by hand on tangents, a solver does what it does in optimistix's own loop; and it is compiled once."""

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest
from stereorecal_optimistix import BFGS, Adam, NelderMead

from stereorecal.strategies import Need, Objective, Status, run_strategy


@pytest.mark.slow(after=2)
def test_it_takes_the_steps_of_optimistix(climb_class, problem):
    start, bowl = np.array([-0.2, 0.1, 0.3]), problem()
    strategy = climb_class()
    run = run_strategy(strategy, Objective(bowl), start)

    def chart(v):
        return jnp.sin(jnp.arcsin(jnp.asarray(start)) + strategy.unit * v)

    v, of_residuals = jnp.zeros(3), strategy.needs is Need.RESIDUALS
    function = bowl.traced.residuals if of_residuals else bowl.traced.soft_count
    scale = strategy.scale(np.asarray(jax.jacobian(lambda v: function(chart(v)))(v), float))
    if of_residuals:
        theirs = optx.least_squares(lambda v, _: bowl.traced.residuals(chart(v)) / scale, strategy.solver(), v)
    else:
        theirs = optx.minimise(
            lambda v, _: -bowl.traced.soft_count(chart(v)) / scale, strategy.solver(), v, max_steps=strategy.steps
        )
    assert len(run.trace.values) == pytest.approx(int(theirs.stats["num_steps"]), abs=1)  # rounding may save a step
    end = np.asarray(chart(theirs.value), float)
    assert run.value >= bowl.values(end[None])[0] - 1e-6
    if climb_class is not Adam:  # which overshoots, so its last point is not its best
        np.testing.assert_allclose(run.best, end, atol=1e-4)


@pytest.mark.slow(after=3)
def test_new_data_and_new_starts_compile_nothing(strategy_class, problem, compilations, traces):
    first, second = problem((0.4, -0.3)), problem((-0.1, 0.2))
    run_strategy(strategy_class(), Objective(first), np.zeros(2))
    before = len(compilations), len(traces)
    run = run_strategy(strategy_class(), Objective(second), np.array([0.3, -0.5]))
    assert (len(compilations), len(traces)) == before
    np.testing.assert_allclose(run.best, [-0.1, 0.2], atol=0.01)


def test_the_listener_hears_a_compilation(compilations):
    jax.jit(lambda x: x * 3.0 + len(compilations))(1.0)
    assert len(compilations) == 1


def test_all_minimisers_share_one_compiled_objective(problem, traces):
    bowl = problem()
    run_strategy(BFGS(), Objective(bowl, 20), np.zeros(3))
    traces.clear()
    run_strategy(Adam(step=0.1), Objective(bowl, 20), np.zeros(3))
    assert not traces


@pytest.mark.slow
@pytest.mark.parametrize("cls", [BFGS, NelderMead])
def test_a_host_that_has_switched_jax_to_64_bits_is_served(cls, problem):
    if not hasattr(jax, "enable_x64"):
        pytest.skip("this JAX has another name for it")
    with jax.enable_x64(True):
        run = run_strategy(cls(), Objective(problem()), np.zeros(3))
    assert run.status is Status.CONVERGED


def test_ctrl_c_comes_through(strategy_class, problem):
    """Between two steps the host is in charge."""

    class Interrupted(Objective):
        calls = 0

        def batch(self, points):
            self.interrupt()
            return super().batch(points)

        def charge(self, cost, best):
            self.interrupt()
            super().charge(cost, best)

        def interrupt(self):
            self.calls += 1
            if self.calls == 3:
                raise KeyboardInterrupt

    objective = Interrupted(problem())
    with pytest.raises(KeyboardInterrupt):
        strategy_class().run(objective, np.full(3, -0.5), 0)
    assert objective.calls == 3
