"""Images of another size than the file says, or of one that it does not say."""

from pathlib import Path

import pytest
import samples
from every import SAMPLES
from test_refusals import refused

from stereorecal import CalibrationWarning
from stereorecal.io import load_rig


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ((32, 24), "leave size out, and resize the rig: rig.resized((32, 24))."),
        ((64, 36), "crop the rig: rig.cropped((64, 36)) if the images are cut out of the middle."),
        ((32, 18), "out of the middle, rig.resized((32, 24)).cropped((32, 18)) if they are resampled, too."),
        ((128, 60), "calibrate for these images, which are larger, and of another ratio of width to height."),
    ],
)
def test_what_to_do_with_images_of_another_size(tmp_path: Path, size: tuple[int, int], words: str):
    (path,) = SAMPLES["kalibr"].write(tmp_path)
    refused(lambda: load_rig(path, size=size), words)


@pytest.mark.parametrize(("size", "far"), [((64, 48), False), ((128, 96), True), ((32, 24), True), ((64, 36), True)])
def test_a_size_that_the_file_does_not_say(tmp_path: Path, size: tuple[int, int], far: bool):
    path = tmp_path / "a.yaml"
    path.write_text(samples.OPENCV.replace("imageSize:", "boats:"))
    if not far:
        assert load_rig(path, unit="mm", size=size).left.size == size
        return
    with pytest.warns(CalibrationWarning, match="is far from the middle of images of") as found:
        load_rig(path, unit="mm", size=size)
    assert len(found) == 1


def test_a_size_that_the_file_says_is_believed(tmp_path: Path):
    (path,) = SAMPLES["kalibr"].write(tmp_path)
    path.write_text(path.read_text().replace("31.5", "12.5"))
    assert load_rig(path, size=(64, 48)).left.size == (64, 48)
