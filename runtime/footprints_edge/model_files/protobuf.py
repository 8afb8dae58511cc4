"""Reading protobuf's wire format: the fields of a message, without a schema and without copies."""

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np

Value: TypeAlias = "int | memoryview"
"""A number, or the bytes of a string, of a message, of packed numbers or of a fixed-size number."""

_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5


def fields(message: memoryview) -> Iterator[tuple[int, Value]]:
    """The fields of a message in order, as (number, value).

    Raises:
        ValueError: If the bytes are no message.
    """
    at, end = 0, len(message)
    while at < end:
        key = message[at]
        at += 1
        if key >= 0x80:  # most fields have a number below 16
            key, at = _varint(message, at - 1)
        number, kind = key >> 3, key & 7
        if number == 0:
            raise ValueError("a field has the number 0")
        if kind == _VARINT:
            value, at = _varint(message, at)
            yield number, value
            continue
        if kind == _BYTES:
            length, at = _varint(message, at)
        elif kind in {_FIXED64, _FIXED32}:
            length = 8 if kind == _FIXED64 else 4
        else:
            raise ValueError(f"a field has the wire type {kind}")
        if length > end - at:
            raise ValueError("it ends in the middle of a field")
        yield number, message[at : at + length]
        at += length


def grouped(message: memoryview) -> dict[int, list[Value]]:
    """The values of a message by the number of their field, each in order.

    Raises:
        ValueError: If the bytes are no message.
    """
    found: dict[int, list[Value]] = {}
    for number, value in fields(message):
        found.setdefault(number, []).append(value)
    return found


def varint_count(packed: memoryview) -> int:
    """How many numbers a packed field has.

    Raises:
        ValueError: If the last one is cut off.
    """
    if len(packed) and packed[-1] >= 0x80:
        raise ValueError("it ends in the middle of a number")
    return int(np.count_nonzero(np.frombuffer(packed, np.uint8) < 0x80))


def varints(packed: memoryview) -> Iterator[int]:
    """The numbers of a packed field, unsigned.

    Raises:
        ValueError: If the last one is cut off.
    """
    at = 0
    while at < len(packed):
        value, at = _varint(packed, at)
        yield value


def signed(value: int) -> int:
    """An int64 from its unsigned varint."""
    return value - (1 << 64) if value >> 63 else value


def message_of(value: Value) -> memoryview:
    """The bytes of a message or string.

    Raises:
        ValueError: If the value is a number.
    """
    if isinstance(value, int):
        raise ValueError("a number stands where a message belongs")
    return value


def number_of(value: Value) -> int:
    """An integer.

    Raises:
        ValueError: If the value is not one.
    """
    if not isinstance(value, int):
        raise ValueError("a message stands where a number belongs")
    return signed(value)


def _varint(message: memoryview, at: int) -> tuple[int, int]:
    """An unsigned number of at most 64 bits, and where it ends."""
    value, shift = 0, 0
    while shift < 64:
        if at >= len(message):
            raise ValueError("it ends in the middle of a number")
        byte = message[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value & (1 << 64) - 1, at
        shift += 7
    raise ValueError("a number has more than 64 bits")
