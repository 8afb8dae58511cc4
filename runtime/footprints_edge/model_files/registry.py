"""The registry of bundled models: their names, files and checksums."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from footprints_edge.errors import ModelError
from footprints_edge.foundation.addresses import without_password

DATA = Path(__file__).parent / "data"
"""Folder of the bundled files and their manifest `models.json`."""


@dataclass(frozen=True)
class BundledModel:
    """A model that comes with the package, as the manifest describes it.

    Attributes:
        name: Name to pass to `load`.
        path: The model file.
        sha256: Expected SHA-256 of the file.
        bytes: Size of the file.
        licence: Licence of the weights.
        description: One line about its purpose.
        default: Whether `load()` returns this model.
    """

    name: str
    path: Path
    sha256: str
    bytes: int
    licence: str
    description: str
    default: bool


def bundled_models() -> list[BundledModel]:
    """All models in the package's manifest `models.json`; empty without a manifest.

    Raises:
        ModelError: If the manifest is damaged.
    """
    manifest = DATA / "models.json"
    try:
        content = json.loads(manifest.read_text(encoding="utf-8"))
        return [
            BundledModel(
                name=name,
                path=DATA / facts["file"],
                sha256=facts["sha256"],
                bytes=facts["bytes"],
                licence=facts["licence"],
                description=facts["description"],
                default=name == content["default"],
            )
            for name, facts in content["models"].items()
        ]
    except FileNotFoundError:
        return []
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ModelError(f"{manifest} is damaged; reinstall footprints-edge") from error


def resolve(model: str | Path | None = None) -> Path:
    """Finds the file of a model.

    Args:
        model: A registered name, a path, or None for the default model.

    Returns:
        Path of an existing file.

    Raises:
        ModelError: If there is no such model; the message lists the registered ones.
    """
    known = {entry.name: entry for entry in bundled_models()}
    if model is not None and str(model) not in known:
        return _file(Path(model), known)
    entry = next((e for e in known.values() if e.name == model or (e.default and not model)), None)
    if entry is None:
        raise ModelError(
            "this installation bundles no model; give a file: load('model.onnx'), or "
            "fp-infer --model model.onnx"
        )
    if not entry.path.is_file():
        raise ModelError(
            f"the file of the bundled model {entry.name!r} is missing: {entry.path}; "
            "reinstall footprints-edge"
        )
    return entry.path


def _file(path: Path, known: Iterable[str]) -> Path:
    if path.is_file():
        return path
    problem = "is a folder" if path.is_dir() else "is neither a file nor a registered name"
    shown = without_password(str(path))
    raise ModelError(f"model {shown!r} {problem}; registered: {', '.join(known) or 'none'}")


def check(path: Path, sha256: str) -> bool:
    """Checks the hash of a bundled file; other files pass.

    Returns:
        Whether the file is a bundled one.

    Raises:
        ModelError: If the hash differs from the manifest.
    """
    for entry in bundled_models():
        if entry.path != path:
            continue
        if entry.sha256 != sha256:
            raise ModelError(
                f"the bundled model {entry.name!r} is damaged: {path} has sha256 {sha256}, "
                f"expected {entry.sha256}; reinstall footprints-edge"
            )
        return True
    return False
