"""SHA-256 fingerprints, by which results and converted models are recognised."""

import hashlib
from collections.abc import Iterable
from pathlib import Path


def sha256_of_bytes(data: bytes) -> str:
    """SHA-256 of some bytes, as hexadecimal digits."""
    return hashlib.sha256(data).hexdigest()


def sha256_of_file(path: Path) -> str:
    """SHA-256 of a file's content, as hexadecimal digits."""
    return sha256_of_bytes(path.read_bytes())


def fingerprint(paths: Iterable[Path]) -> str:
    """SHA-256 of the name, size and modification time of each file; contents are not read.

    A file that does not exist counts as missing, so creating it changes the fingerprint.

    Args:
        paths: the files, in a fixed order.
    """
    digest = hashlib.sha256()
    for path in paths:
        try:
            status = path.stat()
            line = f"{path.name}\t{status.st_size}\t{status.st_mtime_ns}\n"
        except OSError:
            line = f"{path.name}\tmissing\n"
        digest.update(line.encode())
    return digest.hexdigest()
