"""A repair as a Rerun recording: what its page shows, at full size, before and after side by side.

Needs rerun-sdk and matplotlib: pip install 'stereorecal[rerun]'.
"""

import cv2
import matplotlib
import numpy as np
import rerun as rr  # pyright: ignore[reportMissingImports]: an extra
import rerun.blueprint as rrb  # pyright: ignore[reportMissingImports]: an extra
from jaxtyping import UInt8

from stereorecal.report._embedded_images import LINE_COLOURS, line_rows
from stereorecal.report._regions import where
from stereorecal.report._repair_figures import OVER, ROW_COLOURS, row_scale
from stereorecal.report.disparity_map import colour_range
from stereorecal.report.number_text import percent
from stereorecal.report.repair_report import RepairReport, Sight

_QUALITY = cv2.IMWRITE_JPEG_QUALITY, 95
_LINE = 0.75  # half a line's width, in points of the screen
_UNMATCHED = (32, 32, 32, 255)
_STATES = ("before", "after")


def log_repair(stream: rr.RecordingStream, report: RepairReport) -> None:
    """Log the report: under `before` and `after` the rectified pair with its epipolar lines, the disparity, where it
    matched, and the epipolar error over the view; under `verdict` the text. Nothing depends on time."""
    sights = (report.before, report.after)
    least, largest = colour_range([(sight.disparity, sight.valid) for sight in sights])
    for state, sight in zip(_STATES, sights, strict=True):
        _log_pair(stream, state, sight)
        values = np.where(sight.valid, sight.disparity, 0.0).astype(np.float32)
        shown = rr.DepthImage(values, colormap="viridis", depth_range=(least, largest), draw_order=0.0)
        stream.log(f"{state}/disparity", shown, static=True)
        classes = rr.AnnotationContext([(0, "no match", _UNMATCHED), (1, "matched", (0, 0, 0, 0))])
        matched = rr.SegmentationImage(sight.valid.astype(np.uint8), opacity=1.0, draw_order=1.0)
        stream.log(f"{state}/disparity/matched", classes, matched, static=True)
    for state, picture in zip(_STATES, row_pictures(report), strict=False):
        shown = rr.EncodedImage(contents=_jpeg(picture), media_type="image/jpeg")
        stream.log(f"{state}/row_error", shown, static=True)
    stream.log("verdict", rr.TextDocument(verdict_text(report), media_type="text/markdown"), static=True)


def repair_layout(report: RepairReport) -> rrb.Blueprint:
    """What the viewer shows at first: before | after, the pair above its disparity above its epipolar error, and the
    verdict beside them."""
    names = report.names
    columns = []
    for state, name, sight in zip(_STATES, names, (report.before, report.after), strict=True):
        shown = f"{name}: disparity, {percent(float(sight.valid.mean()))} matched"
        views = [
            rrb.Spatial2DView(origin=f"/{state}/pair", name=f"{name}: left and right, with epipolar lines"),
            rrb.Spatial2DView(origin=f"/{state}/disparity", name=shown),
        ]
        if report.rows is not None:
            views.append(rrb.Spatial2DView(origin=f"/{state}/row_error", name=f"{name}: epipolar error over the view"))
        columns.append(rrb.Vertical(*views))
    verdict = rrb.TextDocumentView(origin="/verdict", name="verdict")
    return rrb.Blueprint(rrb.Horizontal(*columns, verdict, column_shares=[3, 3, 2]), collapse_panels=True)


def row_pictures(report: RepairReport) -> list[UInt8[np.ndarray, "h w 3"]]:
    """The epipolar error over the view in the colours of the page, over the left image, before and after; no colour
    where nothing matched. Empty if none was measured."""
    if report.rows is None:
        return []
    (norm, _), image = row_scale(report.rows), report.after.left
    found = []
    for field in (report.rows.field_before, report.rows.field_after):
        colours = 255.0 * matplotlib.colormaps[ROW_COLOURS](norm(np.nan_to_num(field)))[..., :3]
        layers = (colours, np.where(np.isfinite(field), OVER, 0.0)[..., None])
        over, share = (cv2.resize(one, image.shape[::-1], interpolation=cv2.INTER_NEAREST) for one in layers)
        blended = share[..., None] * over + (1.0 - share[..., None]) * image[..., None]
        found.append(blended.clip(0, 255).round().astype(np.uint8))
    return found


def verdict_text(report: RepairReport) -> str:
    """All that is printed of the repair, where depth cannot be trusted, and how to read the pictures, as Markdown."""
    parts = [f"# {report.verdict}", *where(report), f"```text\n{report.text}\n```"]
    parts.append(
        f"**Pair** {report.frame}: follow a line from the left image into the right one; both should show the same "
        "things on it. **Disparity**: one scale for both; near is bright, grey did not match."
    )
    if report.rows is not None:
        parts.append(
            f"**Epipolar error**: white is aligned, full colour {row_scale(report.rows)[1]:.2g} px, on a scale that is "
            "logarithmic beyond 0.2 px; no colour: too few matches there."
        )
    return "\n\n".join(parts)


def _log_pair(stream: rr.RecordingStream, state: str, sight: Sight) -> None:
    both = np.concatenate([sight.left, sight.right], axis=1).clip(0, 255).astype(np.uint8)
    picture = rr.EncodedImage(contents=_jpeg(both), media_type="image/jpeg", draw_order=0.0)
    stream.log(f"{state}/pair", picture, static=True)
    height, width = both.shape
    rows = line_rows(height)
    lines = rr.LineStrips2D(
        [[(0.0, row + 0.5), (float(width), row + 0.5)] for row in rows],  # the viewer's pixels begin at their corner
        colors=[LINE_COLOURS[index % 2] for index in range(len(rows))],
        radii=rr.Radius.ui_points(_LINE),
        draw_order=1.0,
    )
    stream.log(f"{state}/pair/epipolar_lines", lines, static=True)


def _jpeg(picture: UInt8[np.ndarray, "h w *rgb"]) -> bytes:
    """The JPEG of a grey or RGB picture."""
    return cv2.imencode(".jpg", picture[..., ::-1] if picture.ndim == 3 else picture, _QUALITY)[1].tobytes()
