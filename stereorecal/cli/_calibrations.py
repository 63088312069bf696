"""`python -m stereorecal diff` and `convert`, and calibration files as the command line names them: read, compared,
converted.
"""

from dataclasses import replace
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal._version import versions
from stereorecal.cli._calibration_commands import ConvertOptions, DiffOptions
from stereorecal.cli._options import value_of
from stereorecal.cli._output_files import deliver, write_json, written_or_printed
from stereorecal.cli._places import Place, calibration_path, check_places, paths, refuse_replacing_inputs
from stereorecal.cli._shared_options import CalibrationSizeOptions
from stereorecal.geometry import StereoRig
from stereorecal.io import (
    calibration_json,
    check_savable,
    files_read,
    has_own_unit,
    is_data_set,
    load_rig,
    load_scene,
    save_rig,
    save_template,
    unit_read,
    unsaid_unit,
)
from stereorecal.recalibration import difference

SCHEMA = "stereorecal.difference/1"


def says_no_unit(words: str, options: CalibrationSizeOptions) -> bool:
    """Whether the format of a calibration has no unit; False for one that cannot be read, which its reader says."""
    try:
        return not has_own_unit(paths(calibration_path(words, words)), options.format)
    except InputError:
        return False


def rig_at(words: str, options: CalibrationSizeOptions, *, other_says_none: bool) -> StereoRig:
    """The rig in a calibration file, in LEFT,RIGHT, or in a folder, whose images are not looked at if it has a file of
    its own. If the format of the other file says no unit, --unit may be of that one."""
    where = calibration_path(words, words)
    if isinstance(where, Path) and where.is_dir() and is_data_set(where):
        rig = load_scene(where, limit=1).rig
        if rig is None:
            raise InputError(f"{where}: there is no calibration in it; give one that has.")
        return rig
    size, cameras = value_of(options, "size"), value_of(options, "cameras")
    of_other = options.unit is not None and other_says_none and has_own_unit(paths(where), options.format)
    unit = None if of_other else options.unit
    return load_rig(*paths(where), format=options.format, unit=unit, size=size, cameras=cameras)


def diff(options: DiffOptions) -> int:
    """Compare, save, print; returns the exit code."""
    with files_read() as read:
        before, after = (
            rig_at(words, options, other_says_none=options.unit is not None and says_no_unit(other, options))
            for words, other in ((options.before, options.after), (options.after, options.before))
        )
        found = difference(before, after)
    refuse_replacing_inputs(options.places, read)
    names = {"before": options.before, "after": options.after}
    content = {"schema": SCHEMA, "versions": versions(), **names, **found.as_dict()}
    meaning = "epipolar error over the view, depth straight ahead: how wrong the first is if the second is right"
    report = f"{found}\n{meaning}"
    deliver(lambda: options.tell(report), lambda: write_json(content, options.json, force=options.force))
    return 0


def convert(options: ConvertOptions) -> int:
    """Read, write, say so; returns the exit code."""
    if options.target == "-":
        raise InputError("B is -: a calibration is written to a file; give the name of one.")
    target = calibration_path(options.target, "B")
    places = [Place("B", path) for path in paths(target)]
    if options.template:
        source = paths(calibration_path(options.source, "A"))
        refuse_replacing_inputs(places, source, "give another name")
        save_template(source, paths(target)[0], overwrite=options.force)
        if not options.quiet:
            print(f"{options.target}: written; fill in its nulls, from `found`, with T in metres, left to right")
        return 0
    new_says_none = unsaid_unit(None, target, format=options.to) is not None
    with files_read() as read:
        rig = rig_at(options.source, options, other_says_none=new_says_none)
    refuse_replacing_inputs(places, read, "this is what is converted: give another name")
    check_places(places, force=options.force)
    # Without --to the name alone decides, whatever the calibration was read from.
    written = rig if options.to else replace(rig, source=None)
    # --unit is of the file that was read, if that was read with it, and the format of the new one has a unit.
    unsaid = unsaid_unit(written, target, format=options.to)
    unit = None if unsaid is None and unit_read(rig) == options.unit else options.unit

    def save() -> None:
        how = {"format": options.to, "overwrite": options.force, "unit": unit}
        written_or_printed(lambda: save_rig(written, target, **how), lambda: calibration_json(written))
        if not options.quiet:
            print(f"{options.target}: written" + (f" (translation in {unit or unsaid})" if unsaid else ""))

    check_savable(written, target, format=options.to, unit=unit)
    deliver(save)
    return 0
