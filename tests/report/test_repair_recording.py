"""The Rerun recording of a repair, read back: what the page shows, at full size; and where nothing was measured."""

from pathlib import Path

import numpy as np
import pytest
from made_up_repair import made_up
from rrd_files import entities, jpeg

from stereorecal.report.disparity_map import colour_range
from stereorecal.report.repair_report import Conclusion, RepairReport

pytest.importorskip("rerun.chunk", reason="rerun-sdk is not installed")

from stereorecal.report.repair_recording import log_repair, repair_layout, row_pictures
from stereorecal.report.rerun_streams import memory_stream

WIDTH, HEIGHT = 320, 240


def read_back(report: RepairReport, path: Path) -> dict:
    stream, memory = memory_stream(repair_layout(report), report.name)
    log_repair(stream, report)
    path.write_bytes(memory.drain_as_bytes())
    return entities(path)


def test_before_and_after_are_there_at_full_size(tmp_path: Path):
    report = made_up((WIDTH, HEIGHT))
    found = read_back(report, tmp_path / "out.rrd")
    least, largest = colour_range([(sight.disparity, sight.valid) for sight in (report.before, report.after)])
    for state, sight in (("before", report.before), ("after", report.after)):
        pair = jpeg(found[f"/{state}/pair"])
        assert pair.shape == (HEIGHT, 2 * WIDTH, 3)
        assert np.abs(pair[:, :WIDTH, 0].astype(float) - sight.left).mean() < 10
        (lines,) = found[f"/{state}/pair/epipolar_lines"]["LineStrips2D:strips"]
        assert len(lines) == 14
        assert all(first[1] == last[1] and (first[0], last[0]) == (0, 2 * WIDTH) for first, last in lines)
        disparity = found[f"/{state}/disparity"]
        (((shape),),) = disparity["DepthImage:format"]
        assert (shape["width"], shape["height"]) == (WIDTH, HEIGHT)
        values = np.frombuffer(bytes(disparity["DepthImage:buffer"][0][0]), np.float32).reshape(HEIGHT, WIDTH)
        assert np.allclose(values[sight.valid], sight.disparity[sight.valid])
        assert disparity["DepthImage:depth_range"][0][0] == pytest.approx([least, largest])
        matched = bytes(found[f"/{state}/disparity/matched"]["SegmentationImage:buffer"][0][0])
        assert np.array_equal(np.frombuffer(matched, np.uint8).reshape(HEIGHT, WIDTH), sight.valid)
        assert jpeg(found[f"/{state}/row_error"]).shape == (HEIGHT, WIDTH, 3)


def test_the_row_error_is_coloured_where_something_matched():
    report = made_up((WIDTH, HEIGHT))
    before, after = row_pictures(report)
    bare = slice(3 * HEIGHT // 18 + 2, 4 * HEIGHT // 18 - 2), slice(4 * WIDTH // 24 + 2, 5 * WIDTH // 24 - 2)
    grey = np.repeat(report.after.left[bare].round()[..., None], 3, axis=-1)
    assert np.array_equal(before[bare], grey)
    assert np.array_equal(after[bare], grey)
    assert (before[..., 0].astype(float) - before[..., 2]).mean() > 50  # 9 px too low everywhere: red
    assert abs((after[..., 0].astype(float) - after[..., 2]).mean()) < 20


@pytest.mark.parametrize("conclusion", Conclusion)
def test_the_verdict_is_that_of_the_text(tmp_path: Path, conclusion: Conclusion):
    report = made_up(conclusion=conclusion, measured=False)
    found = read_back(report, tmp_path / "out.rrd")
    ((text,),) = found["/verdict"]["TextDocument:text"]
    assert text.startswith(f"# {report.verdict}\n")
    assert report.text in text
    assert not [name for name in found if "row_error" in name]
