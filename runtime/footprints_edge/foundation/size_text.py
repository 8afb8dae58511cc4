"""Parsing of sizes such as ``256x448``, height first."""

import re

from footprints_edge.foundation.types import Size


def parse_size(text: str) -> Size:
    """(H, W) of text such as ``256x448``.

    Raises:
        ValueError: If the text is not a size; the message is meant for users.
    """
    match = re.fullmatch(r"([1-9]\d{0,5})x([1-9]\d{0,5})", text.strip().lower())
    if match is None:
        raise ValueError(f"{text!r} is not a size; give HEIGHTxWIDTH in pixels, such as 256x448")
    return int(match[1]), int(match[2])
