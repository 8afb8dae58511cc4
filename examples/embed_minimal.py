"""Walkable ground in a picture with numpy, onnxruntime and Pillow alone.

`embed_minimal.py MODEL PICTURE` writes ground.png and, in metres, ground_depth_m.npy;
`embed_minimal.py MODEL VECTORS OUT` runs test vectors, for `fp-export check-vectors VECTORS OUT`.
"""

import json
import math
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageOps

os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
import onnxruntime


def find_ground(image: Image.Image, fx: float, fy: float, size: tuple[int, int]) -> dict[str, Any]:
    """Maps of an RGB picture at (h, w); fx and fy are the camera's, in the picture's pixels."""
    facts = session.get_modelmeta().custom_metadata_map
    near, far = map(float, facts["footprints.depth_range_m"].split(","))
    camera = facts["footprints.camera"]
    (h, w), (W, H) = size, image.size
    focal = math.sqrt(fx * w / W * fy * h / H)
    scale = 1 if camera == "none" else focal / float(camera.removeprefix("focal_px="))
    filter = Image.Resampling[facts["footprints.resize"].upper()]
    x = np.asarray(image.resize((w, h), filter))[None]
    (maps,) = session.run(["maps"], {"image": x})
    visible, ground = maps[0, :2] > 0.5
    visible_m, ground_m = scale / (1 / far + (1 / near - 1 / far) * maps[0, 2:])
    return {
        "input": x,
        "maps": maps,
        "visible_ground": visible,
        "ground": ground,
        "hidden_ground": ground & ~visible,
        "visible_depth_m": visible_m,
        "ground_depth_m": np.where(ground, ground_m, np.float32(np.nan)),
    }


session = onnxruntime.InferenceSession(sys.argv[1], providers=["CPUExecutionProvider"])
source = Path(sys.argv[2])
if source.is_dir():
    for entry in json.loads((source / "vectors.json").read_text())["vectors"]:
        image, camera = Image.open(source / entry["files"]["image"]), entry["image_intrinsics_px"]
        (out := Path(sys.argv[3], entry["name"])).mkdir(parents=True, exist_ok=True)
        fx, fy, size = camera["fx"], camera["fy"], entry["network_size_px"]
        for name, array in find_ground(image, fx, fy, size).items():
            np.save(out / f"{name}.npy", array)
else:
    image = ImageOps.exif_transpose(Image.open(source)).convert("RGB")
    focal = max(image.size) / 2 / math.tan(math.radians(30))  # 60 degrees along the longer side
    found = find_ground(image, focal, focal, (256, 448)[:: 1 if image.width > image.height else -1])
    Image.fromarray(found["ground"]).resize(image.size).save("ground.png")
    np.save("ground_depth_m.npy", found["ground_depth_m"])
