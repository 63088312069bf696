"""`python -m stereorecal convert`."""

from dataclasses import replace

from stereorecal._errors import InputError
from stereorecal.cli._calibration_commands import ConvertOptions
from stereorecal.cli._calibration_files import rig_at
from stereorecal.cli._calibration_paths import calibration_path, paths
from stereorecal.cli._output_files import deliver, written_or_printed
from stereorecal.cli._output_places import Place, check_places, refuse_replacing_inputs
from stereorecal.io import calibration_json, check_savable, files_read, save_rig, save_template, unit_read, unsaid_unit


def run(options: ConvertOptions) -> int:
    """Read, write, say so; returns the exit code."""
    if options.target == "-":
        raise InputError("B is -: a calibration is written to a file; give the name of one.")
    target = calibration_path(options.target, "B")
    places = [Place("B", path) for path in paths(target)]
    if options.template:
        refuse_replacing_inputs(places, paths(calibration_path(options.source, "A")), "give another name")
        save_template(paths(calibration_path(options.source, "A")), paths(target)[0], overwrite=options.force)
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
