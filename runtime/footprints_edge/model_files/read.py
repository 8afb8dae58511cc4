"""Reading model files: their bytes, of which an engine sees only what the file contract allows."""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from footprints_edge.errors import ModelError
from footprints_edge.model_files import registry

MAX_BYTES = 512 * 2**20
"""Larger files are no networks of this size class."""

_FOREIGN = {
    b"version https://git-lfs": "it is a Git LFS pointer, not the model; fetch it: git lfs pull",
    b"<": "it is a web page or XML, not a model; download the file itself",
    b"PK\x03\x04": "it looks like a PyTorch checkpoint; convert it with: "
    "fp-export convert CHECKPOINT -o OUT.onnx --arch edge",
}


@dataclass(frozen=True)
class ModelFile:
    """The bytes of a model file.

    Attributes:
        path: The file.
        data: Its bytes.
        sha256: Their SHA-256.
    """

    path: Path
    data: bytes = field(repr=False)
    sha256: str


def read_model_file(path: Path) -> ModelFile:
    """Reads a model file and checks it.

    A bundled file must have the hash of the manifest. Any other ONNX file is looked through, see
    `graph_check`. A file in onnxruntime's own format (`.ort`) is not.

    Raises:
        ModelError: If it cannot be read, is larger than `MAX_BYTES`, is a Git LFS pointer, a web
            page or a checkpoint, or holds what the file contract does not allow.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        reason = getattr(error, "strerror", None) or error
        raise ModelError(f"model file {path} cannot be read: {reason}") from error
    if len(data) > MAX_BYTES:
        raise ModelError(f"model file {path} is larger than {MAX_BYTES} bytes: it is no model")
    for start, reason in _FOREIGN.items():
        if data.startswith(start):
            raise ModelError(f"{path} is not an ONNX model ({len(data)} bytes): {reason}")
    sha256 = hashlib.sha256(data).hexdigest()
    if not registry.check(path, sha256) and data[4:8] != b"ORTM":
        from footprints_edge.model_files.graph_check import check_graph  # not for the bundled file

        try:
            check_graph(data)
        except ValueError as error:
            raise ModelError(
                f"{path} cannot be loaded ({len(data)} bytes, sha256 {sha256}): it is damaged, or "
                f"not a model of footprints-edge: {error}; fetch or convert it again"
            ) from error
    return ModelFile(path, data, sha256)
