"""What an .rrd file holds, as Rerun's own reader reads it; skips where that is not installed."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest


def entities(path: Path) -> dict[str, dict[str, list[Any]]]:
    """The values of each component, row by row, by entity and component."""
    reader = pytest.importorskip("rerun.chunk", reason="rerun-sdk is not installed").RrdReader(path)
    found: dict[str, dict[str, list[Any]]] = {}
    for chunk in reader.stream():
        batch = chunk.to_record_batch()
        here = found.setdefault(chunk.entity_path, {})
        for name in batch.schema.names:
            if ":" in name or name == "pair":
                here.setdefault(name, []).extend(batch.column(name).to_pylist())
    return found


def jpeg(entity: dict[str, list[Any]]) -> np.ndarray:
    """The picture of an entity."""
    (((blob),),) = entity["EncodedImage:blob"]
    picture = cv2.imdecode(np.frombuffer(bytes(blob), np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture
