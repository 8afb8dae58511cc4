"""Test vectors for ports to other languages: images, and everything a model makes of them.

``vectors.json`` says how each was made; ``docs/porting.md`` says how to check a port with them.
"""

import io
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.foundation.types import Floats, Rgb, Size
from footprints_edge.foundation.version import __version__
from footprints_edge.geometry.camera import Intrinsics, disparity_to_depth
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.inputs.images import DecodedImage, decode
from footprints_edge.inputs.preprocessing import preprocess, working_size
from footprints_edge.model import Model
from footprints_edge.navigation.path_planning import require_graph_search
from footprints_edge.prediction import Prediction
from footprints_edge_export.errors import ExportError
from footprints_edge_export.verification.vector_metres import (
    PATH,
    find_corner_path,
    find_named_path,
    grid_facts,
    judge_path,
    metres,
    prediction_of,
)

FORMAT = 2
"""Version of the folder's layout and of ``vectors.json``."""

THRESHOLD = 0.5
EXAMPLE_PHOTO = Path(__file__).with_name("room.jpg")
"""A rendered room of our own, with its camera in EXIF."""

MASKS = ("visible_ground", "ground", "hidden_ground")
METRES = ("visible_depth_m", "ground_depth_m")

_SIZES_TO_TRY = ((720, 1280), (1280, 720), (480, 640), (1000, 1000), (300, 4000), (33, 47))


@dataclass(frozen=True)
class Tolerances:
    """How far a port may be from the vectors.

    The first five allow for rounding in engines: hardly any in float32; in int8 one step in an
    early layer, which becomes a few at the end. The others compare a port's arithmetic with its
    own maps, where engines play no part.

    Attributes:
        probability_mean: mean difference of ``maps`` 0 and 1.
        probability_max: largest difference of ``maps`` 0 and 1.
        depth_median: median relative difference of the depths of ``maps`` 2 and 3.
        depth_p99: the 99th percentile of the same.
        mask_margin: masks are compared where the vector's probability is this far from the
            threshold.
        mask_iou: least intersection over union of each mask there.
        input_levels: largest difference of a byte of the network's input.
        own_mask_iou: least intersection over union with the mask that the port's maps give.
        own_mask_iou_at_image_size: the same, after the resize to the image's size.
        own_metres: largest relative difference from the metres that the port's maps give.
        plane_height: largest relative difference of the camera's height.
        plane_deg: largest angle between the planes, degrees.
        flat_depth_median: median relative difference of the depth laid flat.
        grid_cells: least share of equal cells, of those known in either grid.
        ranges: least share of bearings whose range, within 5 %, or lack of one is the same.
        own_plane_height: as plane_height, from the port's own maps; the others likewise.
        own_plane_deg: as plane_deg.
        own_flat_depth_p99: the 99th percentile of the relative difference.
        own_grid_cells: as grid_cells.
        own_ranges: as ranges.
        own_path_cost: largest relative difference of the path's cost and length.
    """

    probability_mean: float
    probability_max: float
    depth_median: float
    depth_p99: float
    mask_margin: float
    mask_iou: float = 0.995
    input_levels: int = 1
    own_mask_iou: float = 0.9999
    own_mask_iou_at_image_size: float = 0.998
    own_metres: float = 1e-4
    plane_height: float = 0.01
    plane_deg: float = 0.5
    flat_depth_median: float = 0.01
    grid_cells: float = 0.95
    ranges: float = 0.9
    own_plane_height: float = 0.005
    own_plane_deg: float = 0.2
    own_flat_depth_p99: float = 0.01
    own_grid_cells: float = 0.99
    own_ranges: float = 0.97
    own_path_cost: float = 0.05


TOLERANCES = {
    "fp32": Tolerances(1e-4, 1e-2, 1e-3, 1e-2, 0.01),
    "int8": Tolerances(
        0.02,
        0.5,
        0.04,
        0.2,
        0.2,
        plane_height=0.1,
        plane_deg=3,
        flat_depth_median=0.1,
        grid_cells=0.6,
        ranges=0.5,
    ),
}
"""By the precision of the model file."""


@dataclass(frozen=True)
class VectorImage:
    """An image of the vectors.

    Attributes:
        name: name of its folder.
        rgb: uint8 (H, W, 3).
        camera: intrinsics of the image, in its pixels.
        network_size: (h, w) of the network's input, if the model leaves it free; None for the
            usual size.
        pose: what the port is told of the camera's pose.
    """

    name: str
    rgb: Rgb
    camera: Intrinsics
    network_size: Size | None
    pose: CameraPose


def write_vectors(model: Model, folder: Path, photo: Path = EXAMPLE_PHOTO) -> list[Path]:
    """Write the vectors of a model.

    Args:
        model: the model to write vectors of.
        folder: created if needed; files of the same names are replaced.
        photo: a landscape photo with ground in it, 1000 pixels wide or more.

    Returns:
        The files, ``vectors.json`` last.

    Raises:
        ExportError: there is no such photo, the model's precision has no tolerances, or the model
            lacks maps.
        PlanningError: the packages for paths are not installed.
        ImageError: the photo cannot be read.
    """
    if not photo.is_file():
        raise ExportError(f"{photo}: no such photo to cut the vectors from; name one with --photo")
    if model.metadata.precision not in TOLERANCES:
        raise ExportError(
            f"{model.path}: no tolerances are known for precision {model.metadata.precision!r}; "
            f"there are {', '.join(TOLERANCES)}"
        )
    if model.metadata.outputs != "all":
        raise ExportError(
            f"{model.path} has {model.metadata.outputs} only; vectors are of all maps"
        )
    require_graph_search()
    written, entries = [], []
    for image in vector_images(decode(photo)):
        network_input, maps = run_image(model, image)
        entry = _entry(model, image, (maps.shape[2], maps.shape[3]))
        results: dict[str, Any] = {"input": network_input, "maps": maps}
        results |= derived(maps, entry, THRESHOLD)
        results |= _with_path(entry, prediction_of(maps, entry, THRESHOLD))
        files = {"image": _png(image.rgb)}
        for name, result in results.items():
            files[name] = _encoded(result)
        for name, data in files.items():
            path = folder / image.name / f"{name}{_suffix(data)}"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
            entry["files"][name] = path.relative_to(folder).as_posix()
            written.append(path)
        entries.append(entry)
    manifest = folder / "vectors.json"
    manifest.write_text(json.dumps(_manifest(model, entries), indent=2) + "\n")
    return [*written, manifest]


def vector_images(photo: DecodedImage) -> list[VectorImage]:
    """The images: the whole photo, an upright and a square crop of it, small copies, and its top.

    All but the first have small network sizes of their own, so that the files stay small, but not
    so small that a network is in doubt: what the gate says must not hang on a processor's rounding.
    ``refused`` is said to look up by more than the gate believes; ``wall`` shows no ground, if the
    photo has none at its top. Neither has a plane.
    """
    height, width = photo.size
    camera = (
        Intrinsics.from_focal_35mm(photo.focal_35mm, photo.size)
        if photo.focal_35mm is not None
        else Intrinsics.assumed(photo.size)
    )
    upright, square, top = width - 3 * height // 4, width - height, height // 4
    pieces: tuple[tuple[str, int, int, Size, Size | None, CameraPose], ...] = (
        # name, columns from the left that are cut off, rows that are kept, size, network size, pose
        ("landscape", 0, height, (360, 640), None, CameraPose()),
        ("portrait", upright, height, (480, 360), (256, 192), CameraPose(None, 8.0, 0.5)),
        ("square", square, height, (360, 360), (224, 224), CameraPose(height_m=1.4)),
        ("tiny", 0, height, (36, 64), (160, 288), CameraPose()),
        ("known_pose", 0, height, (180, 320), (160, 288), CameraPose(1.4, 8.0, 0.5)),
        ("refused", 0, height, (90, 160), (160, 288), CameraPose(None, -35.0, 0.0)),
        ("wall", 0, top, (45, 320), (64, 320), CameraPose()),
    )
    found = []
    for name, left, rows, size, network_size, pose in pieces:
        box = (left, 0, width, rows)
        rgb = np.asarray(
            Image.fromarray(photo.rgb).resize(size[::-1], Image.Resampling.LANCZOS, box)
        )
        moved = Intrinsics(camera.fx, camera.fy, camera.cx - left, camera.cy)
        found.append(
            VectorImage(name, rgb, moved.scaled((rows, width - left), size), network_size, pose)
        )
    return found


def run_image(model: Model, image: VectorImage) -> tuple[Rgb, Floats]:
    """The network's input uint8 (1, h, w, 3) and its output float32 (1, 4, h, w)."""
    image_size = (image.rgb.shape[0], image.rgb.shape[1])
    size = model.engine.input_size or image.network_size or model.input_size(image_size)
    network_input = preprocess(image.rgb, size, model.metadata.resize)
    return network_input, model.engine.run(network_input)


def derived(maps: Floats, entry: Mapping[str, Any], threshold: float) -> dict[str, NDArray[Any]]:
    """Masks at both sizes and depths in metres, derived from a network's output, by file name.

    Args:
        maps: float32 (1, 4, h, w).
        entry: the vector's entry in ``vectors.json``.
        threshold: probability above which a pixel is ground.
    """
    height, width = entry["image_size_px"]
    found: dict[str, NDArray[Any]] = {}
    for suffix, size in (("", None), ("_at_image_size", (width, height))):
        visible, ground = (_resized(maps[0, channel], size) > threshold for channel in (0, 1))
        masks = (visible, ground, ground & ~visible)
        found |= {name + suffix: mask for name, mask in zip(MASKS, masks, strict=True)}
    visible_m, ground_m = disparity_to_depth(maps[0, 2:], *entry["depth_range_m"])
    metres = (visible_m, np.where(found["ground"], ground_m, np.float32(np.nan)))
    return found | dict(zip(METRES, metres, strict=True))


def _with_path(entry: dict[str, Any], prediction: Prediction) -> dict[str, Any]:
    """The metres of a vector; its entry gets the path's ends."""
    margin_m = 0.1 if entry["name"] == "landscape" else 0.0
    corner = find_corner_path(prediction) if entry["name"] == "known_pose" else None
    named = corner or find_named_path(prediction, margin_m)
    entry["path"] = None if named is None else asdict(named)
    found = metres(prediction, entry)
    if named is not None:
        judged = judge_path(prediction, found[PATH], entry)
        entry["path"] |= {"cost": judged.cost, "length_m": judged.length_m}
    return found


def _resized(values: Floats, size: tuple[int, int] | None) -> Floats:
    """Bilinear, to (width, height)."""
    if size is None:
        return values
    return np.array(Image.fromarray(values).resize(size, Image.Resampling.BILINEAR))


def _entry(model: Model, image: VectorImage, network_size: Size) -> dict[str, Any]:
    image_size = (image.rgb.shape[0], image.rgb.shape[1])
    camera = image.camera.scaled(image_size, network_size)
    focal_px = model.metadata.focal_px
    scale = 1.0 if focal_px is None else camera.focal_px / focal_px
    return {
        "name": image.name,
        "image_size_px": list(image_size),
        "network_size_px": list(network_size),
        "image_intrinsics_px": _camera(image.camera),
        "network_intrinsics_px": _camera(camera),
        "depth_scale": scale,
        "depth_range_m": [scale * bound for bound in model.metadata.depth_range_m],
        "known_pose": {
            "camera_height_m": image.pose.height_m,
            "pitch_deg": image.pose.pitch_deg,
            "roll_deg": image.pose.roll_deg,
        },
        "grid": grid_facts(),
        "path": None,
        "files": {},
    }


def _manifest(model: Model, entries: list[dict[str, Any]]) -> dict[str, Any]:
    fixed = model.engine.input_size
    return {
        "format": FORMAT,
        "model": {
            "name": model.name,
            "file": model.path.name,
            "sha256": model.sha256,
            "precision": model.metadata.precision,
            "resize": model.metadata.resize,
            "focal_px": model.metadata.focal_px,
            "depth_range_m": list(model.metadata.depth_range_m),
            "fixed_size_px": None if fixed is None else list(fixed),
        },
        "versions": {"footprints_edge": __version__, "runtime": model.engine.runtime},
        "threshold": THRESHOLD,
        "tolerances": asdict(TOLERANCES[model.metadata.precision]),
        "size_rule": [
            {"image_size_px": list(size), "network_size_px": list(working_size(size))}
            for size in _SIZES_TO_TRY
        ],
        "vectors": entries,
    }


def _camera(camera: Intrinsics) -> dict[str, float]:
    return {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy}


def _encoded(result: NDArray[Any] | dict[str, Any]) -> bytes:
    if isinstance(result, dict):
        return (json.dumps(result, indent=2) + "\n").encode()
    return _png(result * np.uint8(255)) if result.dtype == np.bool_ else _npy(result)


def _suffix(data: bytes) -> str:
    return {b"\x89PNG": ".png", b"\x93NUM": ".npy"}.get(data[:4], ".json")


def _png(pixels: NDArray[np.uint8]) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def _npy(array: NDArray[Any]) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()
