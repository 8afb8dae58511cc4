"""Synthetic scenes on disk: a JPEG and an npz of 20 to 50 kB per picture, written atomically.

Where scenes have several views, picture number = scene number * views + number of the view.

Depth is stored as inverse depth, in which planes are linear, and as height above a plane where the
ray meets ground: both compress well.
"""

import io
import json
import math
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError, IntrinsicsError
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.geometry.camera import Intrinsics, rays
from footprints_edge_models.bounded_files import decode_picture, read_arrays
from footprints_edge_models.scenes.assets.textures.library import SceneSplit
from footprints_edge_models.scenes.ground_truth.pixels import VISIBLE_GROUND, SceneGroundTruth
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.rendering.cameras import Camera

MANIFEST = "scenes.json"
FORMAT = 1
INVERSE_DEPTH_UNITS = 16384.0
"""Inverse depth is stored in units of 1/INVERSE_DEPTH_UNITS per metre: right to 0.03 % at 10 m and
0.3 % at 100 m; nothing is nearer than 0.25 m."""
NO_GROUND = 255
"""Stored instead of the ground's height in millimetres where the ray meets no ground."""


class SceneFilesError(FootprintsError):
    """A folder of synthetic scenes is missing, damaged, or was begun with other settings."""


@dataclass(frozen=True)
class SceneSettings:
    """Everything that decides the bytes of a folder of scenes, besides their number.

    Attributes:
        split: train or test.
        seed: seed of the set.
        size: (H, W) of its landscape pictures.
        textures: folders of photos: name, and number of photos that belong to the split.
        assets: fingerprint of the pack of assets; empty without one.
        views: how many pictures of each scene there are at most.
    """

    split: SceneSplit
    seed: int
    size: tuple[int, int]
    textures: tuple[tuple[str, int], ...] = ()
    assets: str = ""
    views: int = 1


@dataclass(frozen=True)
class SceneFile:
    """One scene, as read.

    Attributes:
        name: name of the scene in its folder.
        kind: rooms or street.
        image: uint8 (H, W, 3), RGB.
        intrinsics: in pixels of the picture.
        up: unit (3,), away from the ground, in camera axes.
        ground_truth: its exact labels and depths.
    """

    name: str
    kind: str
    image: NDArray[np.uint8] = field(repr=False)
    intrinsics: Intrinsics
    up: NDArray[np.float64]
    ground_truth: SceneGroundTruth = field(repr=False)


def scene_name(number: int) -> str:
    """The name of a scene in its folder."""
    return f"{number:06d}"


def scene_names(folder: Path) -> list[str]:
    """The names of the scenes, in order.

    Raises:
        SceneFilesError: the folder holds no scenes.
    """
    read_settings(folder)
    return sorted(path.stem for path in (folder / "truth").glob("*.npz"))


def scene_bytes(folder: Path, name: str) -> int | None:
    """The bytes that a scene takes; None where it is not there."""
    arrays, image = folder / "truth" / f"{name}.npz", folder / "images" / f"{name}.jpg"
    if not (arrays.is_file() and image.is_file()):
        return None
    return arrays.stat().st_size + image.stat().st_size


def scene_views(folder: Path, name: str) -> int | None:
    """How many views the scene of a picture has; None where it is not there, or damaged."""
    try:
        arrays = read_arrays(folder / "truth" / f"{name}.npz")
        return int(arrays["views"]) if "views" in arrays else 1
    except (OSError, ValueError, TypeError):
        return None


def write_settings(folder: Path, settings: SceneSettings) -> None:
    """Begin a folder, or check that it was begun with the same settings.

    Raises:
        SceneFilesError: it was begun with other settings.
    """
    if (folder / MANIFEST).is_file():
        begun = read_settings(folder)
        if begun != settings:
            raise SceneFilesError(
                f"{folder}: begun as {begun}, not as {settings}; resume with the same settings, "
                "or give another folder"
            )
        return
    for part in ("images", "truth"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    about = {
        "format": FORMAT,
        "split": settings.split,
        "seed": settings.seed,
        "size": list(settings.size),
        "textures": [list(entry) for entry in settings.textures],
        **({"assets": settings.assets} if settings.assets else {}),
        **({"views": settings.views} if settings.views > 1 else {}),
    }
    write_atomically(folder / MANIFEST, (json.dumps(about, indent=1) + "\n").encode())


def read_settings(folder: Path) -> SceneSettings:
    """The settings of a folder of scenes.

    Raises:
        SceneFilesError: it holds none, or those of another version.
    """
    path = folder / MANIFEST
    try:
        about = json.loads(path.read_text(encoding="utf-8"))
        if about["format"] != FORMAT:
            raise SceneFilesError(f"{path}: format {about['format']}, this version reads {FORMAT}")
        return SceneSettings(
            about["split"],
            about["seed"],
            (about["size"][0], about["size"][1]),
            tuple((name, count) for name, count in about["textures"]),
            about.get("assets", ""),
            about.get("views", 1),
        )
    except (OSError, ValueError, KeyError, TypeError, IndexError) as error:
        raise SceneFilesError(
            f"{path}: no readable settings of synthetic scenes ({error}); make them: "
            "fp-train scenes"
        ) from error


def write_scene(
    folder: Path,
    name: str,
    scene: Scene,
    camera: Camera,
    image: NDArray[np.uint8],
    ground_truth: SceneGroundTruth,
    quality: int,
    views: int = 1,
) -> int:
    """Write a picture of a scene that has so many views; returns the bytes that it takes."""
    normal = np.array([-scene.slope[0], -scene.slope[1], 1.0])
    normal /= np.linalg.norm(normal)
    up = camera.rotation.T @ normal
    eye_m = float(normal @ camera.position_m)
    falls = rays(camera.intrinsics, camera.size) @ up
    met = ground_truth.ground_depth_m > 0
    height_m = (eye_m + ground_truth.ground_depth_m * falls) / normal[2]
    # floors of worlds are not all within a kerb's height
    kept: type[np.unsignedinteger[Any] | np.signedinteger[Any]]
    kept = np.int16 if scene.floors else np.uint8
    low, none = (-32767, np.iinfo(kept).max) if scene.floors else (0, NO_GROUND)
    height_mm = np.where(met, np.clip(np.rint(height_m * 1000), low, none - 1), none)
    seen = (ground_truth.visible_depth_m > 0) & (ground_truth.bits & VISIBLE_GROUND == 0)
    inverse = np.zeros(camera.size, np.uint16)
    inverse[seen] = np.clip(
        np.rint(INVERSE_DEPTH_UNITS / ground_truth.visible_depth_m[seen]), 1, 65535
    ).astype(np.uint16)
    arrays: dict[str, Any] = {
        "kind": np.array(scene.kind),
        "intrinsics": np.array(
            [camera.intrinsics.fx, camera.intrinsics.fy, camera.intrinsics.cx, camera.intrinsics.cy]
        ),
        "up": up,
        "eye_m": np.array(eye_m),
        "rise": np.array(normal[2]),
        "bits": ground_truth.bits,
        "ground_height_mm": height_mm.astype(kept),
        "inverse_depth": np.frombuffer(_packed(inverse), np.uint8),
    }
    if used := scene.assets():
        arrays["assets"] = np.array(used)
    if views > 1:
        arrays["views"] = np.array(views)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    flags = [cv2.IMWRITE_JPEG_QUALITY, quality]
    jpeg = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), flags)[1].tobytes()
    write_atomically(folder / "images" / f"{name}.jpg", jpeg)
    write_atomically(folder / "truth" / f"{name}.npz", buffer.getvalue())
    return len(jpeg) + buffer.tell()


def read_scene(folder: Path, name: str) -> SceneFile:
    """Read a scene.

    Raises:
        SceneFilesError: it is missing or damaged.
    """
    path = folder / "truth" / f"{name}.npz"
    try:
        arrays = read_arrays(path)
        kind, up = str(arrays["kind"]), arrays["up"].reshape(3)
        camera = Intrinsics(*arrays["intrinsics"].tolist())
        eye_m, rise = float(arrays["eye_m"]), float(arrays["rise"])
        bits, height_mm = arrays["bits"], arrays["ground_height_mm"]
        whole = {bits.dtype.kind, height_mm.dtype.kind} <= {"i", "u"}
        if bits.ndim != 2 or height_mm.shape != bits.shape or not whole:
            raise ValueError(f"ground truth of {bits.shape} and {height_mm.shape}")
        inverse = _unpacked(arrays["inverse_depth"].tobytes(), bits.shape)
        picture = decode_picture((folder / "images" / f"{name}.jpg").read_bytes())
        if picture.shape[:2] != bits.shape:
            raise ValueError("the picture is not of the ground truth's size")
    except (OSError, ValueError, KeyError, TypeError, zlib.error, IntrinsicsError) as error:
        raise SceneFilesError(f"{path}: no readable scene ({error}); make it again") from error
    falls = rays(camera, bits.shape) @ up.astype(np.float32)
    met = height_mm != np.iinfo(height_mm.dtype).max
    ground_m = np.zeros(bits.shape, np.float32)
    ground_m[met] = (height_mm[met] * np.float32(rise / 1000) - eye_m) / falls[met]
    visible_m = np.zeros(bits.shape, np.float32)
    seen = inverse > 0
    visible_m[seen] = INVERSE_DEPTH_UNITS / inverse[seen]
    is_ground = bits & VISIBLE_GROUND > 0
    visible_m[is_ground] = ground_m[is_ground]
    ground_truth = SceneGroundTruth(bits, visible_m, ground_m)
    return SceneFile(name, kind, cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), camera, up, ground_truth)


def _packed(values: NDArray[np.uint16]) -> bytes:
    """Differences from pixel to pixel, high bytes apart from low ones, compressed."""
    steps = values.copy()
    steps[:, 1:] -= values[:, :-1]
    steps[1:, 0] -= values[:-1, 0]
    folded = (steps << 1) ^ (0 - (steps >> 15))  # small negative steps become small numbers
    planes = np.stack([folded >> 8, folded & 255]).astype(np.uint8)
    return zlib.compress(planes.tobytes(), 6)


def _unpacked(packed: bytes, shape: tuple[int, ...]) -> NDArray[np.uint16]:
    planes = zlib.decompressobj().decompress(packed, 2 * math.prod(shape) + 1)  # no more than fits
    low_high = np.frombuffer(planes, np.uint8).reshape(2, *shape).astype(np.uint16)
    folded = low_high[0] << 8 | low_high[1]
    steps = (folded >> 1) ^ (0 - (folded & 1))
    steps[:, 0] = np.cumsum(steps[:, 0], dtype=np.uint16)
    return np.cumsum(steps, axis=1, dtype=np.uint16)
