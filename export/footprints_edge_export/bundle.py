"""Put a model file into the runtime package, as its default.

    python -m footprints_edge_export.bundle MODEL.onnx --description "What it is for"

Copies the file and its report into ``footprints_edge/model_files/data`` and updates the manifest
there.
"""

import argparse
import json
import shutil
from pathlib import Path

from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge.model import Model
from footprints_edge.model_files.registry import DATA
from footprints_edge_export.report import report_path
from footprints_edge_export.verification.contract import check_file


def bundle(model_path: Path, description: str, data: Path = DATA) -> None:
    """Bundle a model under its own name and make it the default.

    Raises:
        VerificationError: the file breaks the contract.
        ModelError: the runtime cannot load it.
    """
    check_file(model_path)
    model = Model(OnnxRuntimeEngine(model_path))
    data.mkdir(exist_ok=True)
    file = data / f"{model.name}.onnx"
    shutil.copyfile(model_path, file)
    shutil.copyfile(report_path(model_path), report_path(file))
    manifest_path = data / "models.json"
    manifest = json.loads(manifest_path.read_text()) if manifest_path.exists() else {"models": {}}
    manifest["default"] = model.name
    manifest["models"][model.name] = {
        "file": file.name,
        "sha256": model.sha256,
        "bytes": file.stat().st_size,
        "licence": model.metadata.licence,
        "description": description,
    }
    manifest_path.write_text(json.dumps(manifest, indent=2) + "\n")


def main() -> None:
    """Command line of :func:`bundle`."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("--description", required=True)
    options = parser.parse_args()
    bundle(options.model, options.description)


if __name__ == "__main__":
    main()
