"""A semantic segmenter in TFLite format, the teacher whose class ids stand in for human labels."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import ModelError

Segmenter = Callable[[NDArray[np.uint8]], NDArray[np.uint8]]
"""From a picture, uint8 (H, W, 3) RGB, to class ids, uint8 (S, S), that cover all of it."""


def read_segmenter(path: Path) -> Segmenter:
    """The segmenter of a file: uint8 (1, S, S, 3) RGB in, class ids (1, S, S) out.

    Raises:
        ModelError: there is no such file, or it is no such segmenter.
    """
    from ai_edge_litert.interpreter import Interpreter

    if not path.is_file():
        raise ModelError(f"{path}: no such file; the teacher is a segmenter in TFLite format")
    try:
        interpreter = Interpreter(model_path=str(path), num_threads=1)
        interpreter.allocate_tensors()
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{path}: no readable TFLite file ({error})") from error
    given, wanted = interpreter.get_input_details()[0], interpreter.get_output_details()[0]
    if given["dtype"] != np.uint8 or len(given["shape"]) != 4 or len(wanted["shape"]) != 3:
        raise ModelError(
            f"{path}: takes {given['dtype'].__name__} {tuple(given['shape'])} and gives "
            f"{tuple(wanted['shape'])}; a segmenter takes uint8 (1, S, S, 3) and gives class ids "
            "(1, S, S)"
        )
    height, width = given["shape"][1:3]

    def segment(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        resized = cv2.resize(image, (int(width), int(height)), interpolation=cv2.INTER_AREA)
        interpreter.set_tensor(given["index"], resized[None])
        interpreter.invoke()
        return np.asarray(interpreter.get_tensor(wanted["index"])[0], np.uint8)

    return segment
