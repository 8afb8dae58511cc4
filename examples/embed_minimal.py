"""Walkable ground in a picture, in metres, with numpy, onnxruntime and Pillow alone.

`embed_minimal.py MODEL PICTURE` writes ground.png, ground_depth_m.npy (metres), ground_plane.json.
`embed_minimal.py MODEL VECTORS OUT` runs test vectors, for `fp-export check-vectors VECTORS OUT`.
"""

import json
import math
import os
import re
import sys
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from PIL import Image, ImageOps

os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
import onnxruntime

Array: TypeAlias = np.ndarray[Any, Any]


def find_ground(image: Image.Image, lens: Array, size: tuple[int, int]) -> dict[str, Any]:
    """Maps of an RGB picture at (h, w); the lens is [fx, fy, cx, cy] in the picture's pixels."""
    facts = session.get_modelmeta().custom_metadata_map
    near, far = map(float, facts["footprints.depth_range_m"].split(","))
    camera = facts["footprints.camera"]
    (h, w), squeeze = size, np.array(size[::-1]) / image.size
    focal, centre = lens[:2] * squeeze, (lens[2:] + 0.5) * squeeze - 0.5
    scale = 1 if camera == "none" else math.sqrt(focal.prod()) / float(camera.split("=")[1])
    filter = Image.Resampling[facts["footprints.resize"].upper()]
    x = np.asarray(image.resize((w, h), filter))[None]
    (maps,) = session.run(["maps"], {"image": x})
    visible, ground = maps[0, :2] > 0.5
    visible_m, ground_m = scale / (1 / far + (1 / near - 1 / far) * maps[0, 2:])
    v, u = np.indices((h, w))
    rays = np.stack([(u - centre[0]) / focal[0], (v - centre[1]) / focal[1], np.ones((h, w))], -1)
    slope, plane = None, {"refused": "no_ground"}
    surest = float(np.sort(maps[0, 1], axis=None)[int(0.98 * (h * w - 1))].clip(2.473e-3, 0.997527))
    if math.log(surest / (1 - surest)) + 2.500 * (1 - maps[0, 1, : h // 4].mean()) >= 5.209:
        slope, plane = fit_plane(rays, 1 / ground_m.astype(float), ground)
    flat_m = ground_m if slope is None else lay_flat(ground_m, rays @ slope)
    return {
        "input": x,
        "maps": maps,
        "visible_ground": visible,
        "ground": ground,
        "hidden_ground": ground & ~visible,
        "visible_depth_m": visible_m,
        "ground_depth_m": np.where(ground, ground_m, np.float32(np.nan)),
        "ground_plane": plane,
        "flat_ground_depth_m": np.where(ground, flat_m, np.nan),
    }


def fit_plane(rays: Array, inverse: Array, ground: Array) -> tuple[Array | None, dict[str, Any]]:
    """The m of `m . ray = 1 / depth` on most of the ground, and the plane (docs/porting-metres)."""
    q, d = rays[ground], inverse[ground]
    if (count := len(d)) < 20:
        return None, {"refused": "few_pixels"}
    if count > 8000:
        even = np.arange(8000) * count // 8000
        q, d = q[even], d[even]
    triples, judged = np.split(draw(1050, len(d)), [450])
    corners = triples.reshape(150, 3)
    corners = corners[np.abs(np.linalg.det(q[corners])) > 1e-9]
    if len(corners) == 0:
        return None, {"refused": "one_line"}
    slopes = np.linalg.solve(q[corners], d[corners][..., None])[..., 0]
    m = slopes[np.sort(np.abs(slopes @ q[judged].T - d[judged]))[:, 300].argmin()]
    for _ in range(6):
        off = np.abs(q @ m - d)
        near = off <= max(2.5 * 1.4826 * np.median(off), 1e-9)
        m = np.linalg.lstsq(q[near], d[near], rcond=None)[0]
    height_m = 1 / np.linalg.norm(m)
    up = -m * height_m
    pitch, roll = math.asin(-up[2]), math.atan2(-up[0], -up[1])
    log_ratio = np.log(np.maximum(q @ m / d, 1e-6))
    refusals = {
        "above_camera": up[1] > 0.2,
        "little_ground": count < 0.02 * ground.size,
        "impossible_pose": not 0.03 <= height_m <= 100
        or math.degrees(pitch) < -30
        or abs(up[0]) > math.sin(math.radians(45)),
        "not_flat": np.median(np.abs(log_ratio - np.median(log_ratio))) > 0.15,
    }
    if refused := next((word for word, holds in refusals.items() if holds), None):
        return None, {"refused": refused}
    return m, {
        "refused": None,
        "up": up.tolist(),
        "camera_height_m": height_m,
        "pitch_deg": math.degrees(pitch),
        "roll_deg": math.degrees(roll),
    }


def draw(times: int, count: int) -> Array:
    """The numbers from 0 to count - 1 that every port draws: the finaliser of MurmurHash3."""
    x = np.arange(times, dtype=np.uint32)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35), (16, 1)):
        x = (x ^ x >> shift) * np.uint32(factor)
    return (x.astype(np.uint64) * np.uint64(count) >> np.uint64(32)).astype(int)


def input_size(width: int, height: int) -> tuple[int, int]:
    """The network's input size (h, w) for a picture of any shape."""
    sides = range(64, 2080, 32)
    return min(
        ((h, w) for h in sides for w in sides if h * w <= 1.15 * 256 * 448),
        key=lambda size: (
            abs(math.log(size[1] * height / size[0] / width))
            + 0.25 * abs(math.log(size[0] * size[1] / (256 * 448)))
        ),
    )


def focal_px(photo: Image.Image) -> float:
    """By what the file of a picture states, before it is turned upright (docs/porting.md)."""
    exif, (w, h) = photo.getexif(), photo.size
    more, xmp = exif.get_ifd(0x8769), str(photo.info.get("xmp", ""))
    mm, zoom, W, H = (float(more.get(key, 0)) for key in (0xA405, 0xA404, 0xA002, 0xA003))
    pano = dict(re.findall(r"(?<!/)GPano:(\w+)\W+(\w+)", xmp))
    is_pano = "GPano" in xmp and pano.get("ProjectionType", "").lower() != "rectilinear"
    if is_pano or more.get(0xA401) == 6:
        sides = [pano.get(f"{key}WidthPixels", "") for key in ("CroppedAreaImage", "FullPano")]
        shown, full = map(int, sides) if all(map(str.isdigit, sides)) else (1, 1)
        if not 0 < shown <= full / 4:  # more than 90 degrees
            sys.exit("a panorama, which no lens takes: cut a view out of it")
        return w / math.tau / shown * full
    if min(W, H) >= 1 and (W > H) != (w > h) and w != W and h != H:
        W, H = H, W  # a program turned it, and kept what EXIF says
    is_crop = min(W, H) >= 1 and abs(W / H * h / w - 1) > 0.02
    if not 4 <= mm <= 5000 or (is_crop and (w > W or h > H)):
        return max(w, h) / 2 / math.tan(math.radians(30))  # assumed: 60 degrees
    is_zoomed = 1 < zoom <= 200 and not str(exif.get(0x10F, "")).startswith("Apple")
    diagonal = math.hypot(W, H) if is_crop else math.hypot(w, h)
    return mm * (zoom if is_zoomed else 1) * diagonal / math.hypot(36, 24)


def lay_flat(depth_m: Array, plane: Array) -> Array:
    """The depth moved onto the plane, given by its inverse depth, where it lies close to it."""
    falls = plane > 1e-4
    off = np.where(falls, np.abs(np.log(np.where(falls, plane, 1) * depth_m)), np.inf)
    weight = np.clip((0.8 - off) / 0.4, 0, 1)
    return 1 / (1 / depth_m + weight * (plane - 1 / depth_m))


def main() -> None:
    """Ground of a picture, or of test vectors."""
    source = Path(sys.argv[2])
    if not source.is_dir():
        photo = Image.open(source)
        focal, image = focal_px(photo), ImageOps.exif_transpose(photo).convert("RGB")
        lens = np.array([focal, focal, (image.width - 1) / 2, (image.height - 1) / 2])
        found = find_ground(image, lens, input_size(*image.size))
        Image.fromarray(found["ground"]).resize(image.size).save("ground.png")
        np.save("ground_depth_m.npy", found["flat_ground_depth_m"])
        Path("ground_plane.json").write_text(json.dumps(found["ground_plane"]))
        return
    for entry in json.loads((source / "vectors.json").read_text())["vectors"]:
        image, camera = Image.open(source / entry["files"]["image"]), entry["image_intrinsics_px"]
        (out := Path(sys.argv[3], entry["name"])).mkdir(parents=True, exist_ok=True)
        lens = np.array([camera[key] for key in ("fx", "fy", "cx", "cy")])
        found = find_ground(image, lens, entry["network_size_px"])
        plane, flat_m = found.pop("ground_plane"), found.pop("flat_ground_depth_m")
        if not any(entry["known_pose"].values()):  # this program fits the whole pose
            (out / "ground_plane.json").write_text(json.dumps(plane))
            np.save(out / "flat_ground_depth_m.npy", flat_m)
        for name, array in found.items():
            np.save(out / f"{name}.npy", array)


if __name__ == "__main__":
    session = onnxruntime.InferenceSession(sys.argv[1], providers=["CPUExecutionProvider"])
    main()
