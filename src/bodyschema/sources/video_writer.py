"""Write pictures one after the other into a video file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema.atomic import new_file
from bodyschema.errors import InputError, MissingExtraError

Pixels = NDArray[np.uint8]

OPTIONS = {"preset": "veryfast", "x264-params": "mbtree=0"}
"""With its tree of macroblocks the encoder gives other bytes for the same small pictures."""


@contextmanager
def video_writer(
    path: Path, size: tuple[int, int], fps: float
) -> Iterator[Callable[[Pixels], None]]:
    """Yield a function that takes the next picture, (height, width, 3) red, green, blue.

    The file appears whole at the end, or not at all. An odd last row or column is cut off, as the
    colours of a video are stored for squares of four pixels.

    Args:
        path: of an .mp4 file.
        size: width and height of all pictures, pixels.
        fps: pictures a second.

    Raises:
        InputError: the place cannot be written, or a picture has another size.
        MissingExtraError: PyAV or OpenCV is not installed.
    """
    try:
        import av
        import cv2
    except ImportError:
        raise MissingExtraError("av", "vision", "writing videos") from None
    width, height = size[0] // 2 * 2, size[1] // 2 * 2
    with new_file(path) as temporary, av.open(str(temporary), "w") as container:
        rate = Fraction(fps).limit_denominator(1000)
        stream = container.add_stream("libx264", rate, options=OPTIONS)
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        # One thread: the bytes must not depend on how many cores there are.
        stream.codec_context.thread_count = 1

        def write(picture: Pixels) -> None:
            if picture.shape != (size[1], size[0], 3):
                raise InputError(
                    f"expected a picture of shape {(size[1], size[0], 3)}, got {picture.shape}."
                )
            whole = np.ascontiguousarray(picture[:height, :width])
            # FFmpeg's own conversion reads beyond the rows, so that the bytes would vary.
            colours = cv2.cvtColor(whole, cv2.COLOR_RGB2YUV_I420)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(colours, format="yuv420p")))

        yield write
        container.mux(stream.encode())
