"""Hypothesis strategies that spoil sound files: their bytes, words, or fields of a message."""

import io
import math
import struct
import zipfile
from collections.abc import Sequence
from typing import Any

from hypothesis import strategies as st

NUMBERS = (0, 1, 2, 127, 128, 255, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**40, 2**62)
WORDS = (
    *(
        "nan",
        "inf",
        "-inf",
        "-1",
        "0",
        "1e308",
        "1e-320",
        "1" + "0" * 400,
        "9" * 5000,
        "²",
        "\u0661",
    ),
    *("", "\0", "\n", "\x1b[2J", "\u202e", "null", "true", "{}", "[]", "[" * 5000, "a: &a [*a]"),
    *("../../x", "/etc/passwd", "%s%n", "%YAML:1.0", "!!opencv-matrix", "x" * 300, "#", ",", '"'),
)


@st.composite
def edited_bytes(draw: Any, seeds: Sequence[bytes]) -> bytes:
    """One of `seeds` with one to four edits."""
    data = bytearray(draw(st.sampled_from(seeds)))
    for _ in range(draw(st.integers(1, 4))):
        end = draw(st.sampled_from([len(data), min(len(data), 256)]))  # headers are more worth
        at = min(draw(st.integers(0, max(0, end - 1))), len(data))
        kind = draw(st.sampled_from(["set", "flip", "number", "cut", "drop", "double", "insert"]))
        if kind == "set" and data:
            data[at] = draw(st.sampled_from([0, 1, 0x7F, 0x80, 0xFF]))
        elif kind == "flip" and data:
            data[at] ^= 1 << draw(st.integers(0, 7))
        elif kind == "number":
            form = draw(st.sampled_from(["<H", ">H", "<I", ">I", "<Q", ">Q"]))
            value = draw(st.sampled_from(NUMBERS)) % 2 ** (8 * struct.calcsize(form))
            data[at : at + struct.calcsize(form)] = struct.pack(form, value)
        elif kind == "cut":
            del data[at:]
        elif kind == "drop":
            del data[at : at + draw(st.integers(1, 64))]
        elif kind == "double":
            data[at:at] = data[at : at + draw(st.integers(1, 64))]
        else:
            data[at:at] = draw(st.binary(min_size=1, max_size=8))
    return bytes(data)


@st.composite
def edited_text(draw: Any, seeds: Sequence[str]) -> bytes:
    """One of `seeds` with one to three words or lines replaced, dropped or doubled."""
    lines = [line.split(" ") for line in draw(st.sampled_from(seeds)).split("\n")]
    for _ in range(draw(st.integers(1, 3))):
        line = lines[draw(st.integers(0, len(lines) - 1))]
        at = draw(st.integers(0, len(line) - 1))
        kind = draw(st.sampled_from(["word", "word", "word", "number", "drop", "double", "line"]))
        if kind == "word":
            line[at] = draw(st.sampled_from(WORDS))
        elif kind == "number":
            line[at] = repr(draw(st.one_of(st.floats(), st.integers(-(2**70), 2**70))))
        elif kind == "drop" and len(line) > 1:
            del line[at]
        elif kind == "double":
            line.insert(at, line[at])
        elif kind == "line" and len(lines) > 1:
            lines.remove(line)
    text = "\n".join(" ".join(line) for line in lines)
    return text.encode("utf-8", "surrogateescape")


@st.composite
def edited_zip(draw: Any, data: bytes) -> bytes:
    """A zip whose bytes are spoiled, or those of a file in it, whose checksum is right then."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        files = {entry.filename: archive.read(entry) for entry in archive.infolist()}
    name = draw(st.sampled_from(["", *sorted(files)]))
    if not name:
        return draw(edited_bytes([data]))
    whole = files[name]
    if zipfile.is_zipfile(io.BytesIO(whole)):
        files[name] = draw(edited_zip(whole))
    elif name.endswith(".json"):
        files[name] = draw(edited_text([whole.decode()]))
    else:
        files[name] = draw(edited_bytes([whole]))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for each, content in files.items():
            archive.writestr(each, content)
    return buffer.getvalue()


@st.composite
def edited_message(draw: Any, message: Any) -> bytes:
    """A copy of a protobuf message in which one to three fields, at any depth, are changed."""
    changed = type(message)()
    changed.CopyFrom(message)
    for _ in range(draw(st.integers(1, 3))):
        _change(draw, changed)
    return bytes(changed.SerializeToString())


def _change(draw: Any, message: Any) -> None:
    """Walks down to a field and changes it."""
    fields = message.ListFields()
    while fields:
        field, value = draw(st.sampled_from(fields))
        many = hasattr(value, "__len__") and not isinstance(value, (str, bytes))
        at = draw(st.integers(0, len(value) - 1)) if many else 0
        if field.message_type is None:
            old = value[at] if many else value
            try:
                if many:
                    value[at] = _scalar(draw, old)
                else:
                    setattr(message, field.name, _scalar(draw, old))
            except (ValueError, TypeError):  # out of the field's range
                pass
            return
        what = draw(st.sampled_from(["down", "down", "down", "down", "down", "drop", "double"]))
        if many and what == "drop":
            del value[at]
            return
        if many and what == "double":
            value.add().CopyFrom(value[at])
            return
        message = value[at] if many else value
        fields = message.ListFields()


def _scalar(draw: Any, old: Any) -> Any:
    if isinstance(old, bool):
        return not old
    if isinstance(old, int):
        return draw(st.sampled_from([*NUMBERS, -1, -(2**31), 2**63 - 1, -(2**63), old + 1]))
    if isinstance(old, float):
        return draw(st.sampled_from([0.0, -1.0, math.nan, math.inf, 1e38]))
    if isinstance(old, bytes):
        return draw(edited_bytes([old]))
    return draw(st.sampled_from([*WORDS[:20], "Loop", "Abs", "maps", "image", "A" * 5000]))
