"""`compare_field`: every method meets every case; what is finished already is not done again."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor
from dataclasses import asdict, replace

from stereorecal import InputError
from stereorecal.cli import Progress, hold, run_all, versions
from stereorecal.matching import AbstractMatcher, as_matcher, name_of, origin_of
from stereorecal.objectives import Reach
from stereorecal_field.judges import AbstractRecipe, Draws
from stereorecal_field.table._field_result import Field
from stereorecal_field.table._field_trial import FieldTask, FieldTrial, failed, run_field_trial
from stereorecal_field.table._methods import AbstractMethod


def planned(
    judges: Sequence[str],
    recipes: Sequence[AbstractRecipe],
    methods: Sequence[AbstractMethod],
    *,
    matcher: AbstractMatcher | str | None,
    draws: Draws,
    reach: Reach | None,
) -> tuple[Field, tuple[FieldTask, ...]]:
    """The empty table, and its trials.

    Args:
        judges: as they were asked for.
        reach: default the larger of 3 degrees, 3 % and 1.2 x the drift.

    Raises:
        InputError: if there is nothing to do, or two cases have one name.
    """
    if not recipes or not methods:
        raise InputError("there is nothing to compare; give at least one judge, one method and one draw.")
    if len({recipe.key for recipe in recipes}) < len(recipes):
        raise InputError("two scenes of a judge have the same name; give each judge and each folder once.")
    matcher = as_matcher(matcher)
    if reach is None:
        reach = Reach(max(3.0, 1.2 * draws.degrees), max(0.03, 1.2 * draws.baseline_fraction))
    settings = {
        "judges": list(judges),
        "methods": [method.name for method in methods],
        "matcher": {"name": name_of(matcher), "origin": origin_of(matcher), **asdict(matcher)},
        "draws": asdict(draws),
        "reach": asdict(reach),
    }
    judged_by = {recipe.judge: recipe.judged_by for recipe in recipes}
    about = tuple({"name": one.name, "changes": one.changes, "origin": one.origin} for one in methods)
    tasks = tuple(
        FieldTask(recipe, method, matcher, reach, draws.seed + (recipe.draw or 0))
        for recipe in recipes
        for method in methods
    )
    return Field(settings, versions(), judged_by, about, (), len(tasks)), tasks


def compare_field(
    empty: Field,
    tasks: Sequence[FieldTask],
    *,
    done: Mapping[str, FieldTrial] | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    on_trial: Callable[[Field], None] | None = None,
    on_loss: Callable[[BaseException], None] | None = None,
) -> Field:
    """Run the trials of `planned`. Ctrl-C ends it; what is finished is returned.

    A trial whose worker died, or that the executor cancelled, is missing: nobody knows what would have come of it.

    Args:
        done: trials that are finished already, by key.
        executor: any `concurrent.futures.Executor`; default one trial after the other in this process.
        progress: called with (finished, total) after each trial.
        on_trial: called with the table so far after each trial, such as to save it.
        on_loss: called once, with the reason, when the executor has lost trials.
    """
    found = {key: trial for key, trial in (done or {}).items() if key in {task.key for task in tasks}}
    unfinished = [task for task in tasks if task.key not in found]
    lost = False

    def so_far() -> Field:
        return replace(empty, trials=tuple(found[task.key] for task in tasks if task.key in found))

    try:
        if progress is not None:
            progress(len(found), len(tasks))
        for index, trial in run_all(run_field_trial, unfinished, executor):
            if isinstance(trial, BrokenExecutor | CancelledError):
                if on_loss is not None and not lost:
                    on_loss(trial)
                lost = True
                continue
            key = unfinished[index].key
            found[key] = trial if isinstance(trial, FieldTrial) else failed(unfinished[index], trial)
            if on_trial is not None:
                on_trial(so_far())
            if progress is not None:
                progress(len(found), len(tasks))
        hold()
    except KeyboardInterrupt:
        pass
    return so_far()
