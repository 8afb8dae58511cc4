"""Plain message contents as the messages of a library."""

from array import array
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np


def fill(
    contents: Any,  # noqa: ANN401 - any value of a field
    make: Callable[..., Any],
    as_array: Callable[[Any], Any] = lambda values: values,
) -> Any:  # noqa: ANN401 - the library's own class
    """A message with these contents.

    Args:
        contents: One of `footprints_edge.ros.messages`.
        make: Makes a message of a type, such as `nav_msgs/msg/OccupancyGrid`, from its fields as
            keywords: `make(type, **fields)`.
        as_array: What becomes of numpy arrays; rosbags takes them as they are, rclpy `plain_array`.
    """
    if isinstance(contents, tuple):
        return [fill(each, make, as_array) for each in contents]
    if isinstance(contents, np.ndarray):
        return as_array(contents)
    if not hasattr(contents, "TYPE"):
        return contents
    return make(
        contents.TYPE,
        **{
            field.name: fill(getattr(contents, field.name), make, as_array)
            for field in fields(contents)
        },
    )


def plain_array(values: Any) -> "array[Any]":  # noqa: ANN401 - a numpy array of any type
    """An array of the standard library, which rclpy takes without looking at each number."""
    plain: array[Any] = array(values.dtype.char)
    plain.frombytes(values.tobytes())
    return plain
