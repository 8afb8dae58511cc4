"""Slight damage of picture files that leaves the picture whole, or nearly so."""

import zlib

import numpy as np

from footprints_edge.foundation.types import Rgb

_PNG = b"\x89PNG\r\n\x1a\n"
_NOTES = {b"tEXt", b"zTXt", b"iTXt", b"iCCP", b"tIME", b"eXIf"}
"""Chunks of a PNG that say something about the picture; its colours are not converted."""

_MOST_LOST = 1 / 16
"""Share of a JPEG's rows that may be lost at its end."""

_END = b"\xff\xd9"
_BASELINE = (b"\xff\xc0", b"\xff\xc1")


def without_notes(data: bytes) -> bytes | None:
    """A PNG without texts and profiles, which may be too long or have a wrong checksum.

    None if it is no PNG or has none of them. Chunks with orientation or the focal length stay if
    they are sound.
    """
    if not data.startswith(_PNG):
        return None
    kept, at, dropped = [_PNG], len(_PNG), False
    while at + 12 <= len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        end = at + 12 + length
        kind = data[at + 4 : at + 8]
        sound = kind == b"eXIf" and _checksum_holds(data, at, length)
        if kind in _NOTES and not sound:
            dropped = True
        else:
            kept.append(data[at:end])
        at = end
    kept.append(data[at:])
    return b"".join(kept) if dropped else None


def _checksum_holds(data: bytes, at: int, length: int) -> bool:
    stated = int.from_bytes(data[at + 8 + length : at + 12 + length], "big")
    return zlib.crc32(data[at + 4 : at + 8 + length]) == stated


def with_end(data: bytes) -> bytes | None:
    """A JPEG that stops early, with the mark of its end; None if it is no such file.

    A decoder fills the rest with one colour; see `lost_share`. Of a progressive JPEG it cannot be
    told how much is lost, so those are left alone.
    """
    if not data.startswith(b"\xff\xd8") or data.rstrip(b"\0").endswith(_END):
        return None
    return data + _END if _is_baseline(data) else None


def _is_baseline(data: bytes) -> bool:
    """Whether the frame's marker, which precedes the first scan, is that of a baseline JPEG."""
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at : at + 2]
        if marker == b"\xff\xda":
            return False
        if 0xC0 <= marker[1] <= 0xCF and marker[1] not in {0xC4, 0xC8, 0xCC}:
            return marker in _BASELINE
        at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return False


def lost_share(stored: Rgb) -> float:
    """The share of rows at the end that have the colour of the last pixel: those may be lost.

    Args:
        stored: uint8 (H, W, 3), not turned upright.
    """
    same = (stored == stored[-1, -1]).all(axis=(1, 2))
    lost = len(same) if same.all() else int(np.argmin(same[::-1]))
    return lost / len(same)


def too_much_lost(stored: Rgb) -> bool:
    """Whether more of a JPEG is lost than its last rows."""
    return lost_share(stored) > _MOST_LOST
