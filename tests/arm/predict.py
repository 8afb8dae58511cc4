"""What the Python runtime makes of test vectors, as a port writes it; on Arm, too.

python predict.py VECTORS OUT_DIR MODEL [ENGINE [OPTION=VALUE...]]
"""

import io
import json
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import footprints_edge as fp
from footprints_edge.errors import PlanningError
from footprints_edge_export.verification.test_vectors import VectorImage, derived, run_image
from footprints_edge_export.verification.vector_metres import metres, prediction_of


def main(vectors: Path, outputs: Path, file: Path, engine: str, *options: str) -> None:
    given = dict(each.split("=", 1) for each in options)
    model = fp.load(file, threads=1, engine=engine, session_options=given or None)
    manifest = json.loads((vectors / "vectors.json").read_text())
    for entry in manifest["vectors"]:
        camera = fp.Intrinsics(**entry["image_intrinsics_px"])
        rgb = np.asarray(Image.open(vectors / entry["files"]["image"]).convert("RGB"))
        size = tuple(entry["network_size_px"])
        network_input, maps = run_image(model, VectorImage(entry["name"], rgb, camera, size, None))
        found = {"input": network_input, "maps": maps}
        found |= derived(maps, entry, manifest["threshold"])
        prediction = prediction_of(maps, entry, manifest["threshold"])
        try:
            found |= metres(prediction, entry)
        except PlanningError:  # these maps have no such path
            found |= metres(prediction, {**entry, "path": None})
        folder = outputs / entry["name"]
        folder.mkdir(parents=True, exist_ok=True)
        for name, result in found.items():
            if isinstance(result, dict):
                (folder / f"{name}.json").write_text(json.dumps(result))
            else:
                buffer = io.BytesIO()
                np.save(buffer, result)
                (folder / f"{name}.npy").write_bytes(buffer.getvalue())


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:4]), *(sys.argv[4:] or ["onnxruntime"]))
