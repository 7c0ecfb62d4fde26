"""What a script with OpenCV alone does to a video: the peer of ``endocal bench correct``.

``python -m endocal.benchmarks.cv2_video INPUT OUTPUT LAMBDA``. It loses sound, tags and uneven times.
"""

from __future__ import annotations

import sys

import cv2
import numpy as np

from ..model import DivisionModel


def main(source: str, target: str, lam: float) -> None:
    """Correct ``source`` with a division model about the frame's centre and write ``target``."""
    capture = cv2.VideoCapture(source)
    w, h = (int(capture.get(k)) for k in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
    model = DivisionModel(lam, ((w - 1) / 2, (h - 1) / 2), (w, h))
    grid = np.stack(np.meshgrid(np.arange(w), np.arange(h)), axis=-1)
    places = model.distort(grid).astype(np.float32)
    x, y = (np.ascontiguousarray(places[..., axis]) for axis in (0, 1))
    writer = cv2.VideoWriter(
        target, cv2.VideoWriter.fourcc(*"mp4v"), capture.get(cv2.CAP_PROP_FPS), (w, h)
    )
    while True:
        found, frame = capture.read()
        if not found:
            break
        writer.write(cv2.remap(frame, x, y, cv2.INTER_LINEAR))
    writer.release()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], float(sys.argv[3]))
