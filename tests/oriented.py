"""Image files with an EXIF orientation."""

import struct
import zlib

import cv2
import numpy as np


def exif(tag: int, order: str = "<") -> bytes:
    head = b"II" if order == "<" else b"MM"
    return head + struct.pack(f"{order}HIHHHIHHI", 42, 8, 1, 0x0112, 3, 1, tag, 0, 0)


def tagged(image: np.ndarray, tag: int, ending: str = ".jpg", order: str = "<") -> bytes:
    """An image file with an EXIF orientation."""
    data, facts = cv2.imencode(ending, image)[1].tobytes(), exif(tag, order)
    match ending:
        case ".jpg":
            body = b"Exif\0\0" + facts
            return data[:2] + b"\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body + data[2:]
        case ".png":
            chunk = b"eXIf" + facts
            return data[:33] + struct.pack(">I", len(facts)) + chunk + struct.pack(">I", zlib.crc32(chunk)) + data[33:]
        case _:
            kinds, facts = [cv2.IMAGE_METADATA_EXIF], [np.frombuffer(facts, np.uint8)]
            return cv2.imencodeWithMetadata(ending, image, kinds, facts)[1].tobytes()


def stored(image: np.ndarray, tag: int) -> np.ndarray:
    """The pixels that an orientation turns to an image."""
    shown = [lambda i: i, np.fliplr, lambda i: np.rot90(i, 2), np.flipud]
    shown += [np.transpose, lambda i: np.rot90(i, 1), lambda i: np.rot90(i.T, 2), lambda i: np.rot90(i, -1)]
    return np.ascontiguousarray(shown[tag - 1](image))
