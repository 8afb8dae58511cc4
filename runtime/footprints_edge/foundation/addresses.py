"""Addresses such as `rtsp://USER:PASSWORD@HOST/PATH`, which may be given where files are."""

import re
from pathlib import Path

_BEGINNING = re.compile(r"(?i)^([a-z][a-z0-9+.-]+):/{1,2}")
"""One slash is left where an address was taken for a path; one letter is a drive of Windows."""

_SECRET = re.compile(
    r"(?i)([?&][^=&]*(?:pass|pwd|key|token|secret|auth|credential|sig)[^=&]*=)[^&]*"
)


def is_address(named: str) -> bool:
    """Whether a name begins as an address does, and no file has it."""
    return _BEGINNING.match(named) is not None and not Path(named).exists()


def without_password(named: str) -> str:
    """The name as it may be printed: of an address without its user, password and keys."""
    if (beginning := _BEGINNING.match(named)) is None:
        return named
    address = named[beginning.end() :]
    user, at, place = address.rpartition("@")
    shown = f"***@{place}" if at and user else address
    return f"{beginning[1]}://" + _SECRET.sub(r"\1***", shown)
