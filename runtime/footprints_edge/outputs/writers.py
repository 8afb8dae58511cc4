"""Output formats: encoders, file names and atomic writing."""

import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from footprints_edge.errors import MissingMapError, OutputError
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.foundation.png import encode_png
from footprints_edge.foundation.real_path import real_path
from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.maps.ground_maps import GroundMaps

NAMELESS = "image"
"""Name of the outputs of a picture without a file name."""

FARTHEST_MM = 65535
"""Largest value of a depth PNG: 65.535 m or more. 0 means no depth."""

_MAP_PNG = ".topdown.png"

Encoder = Callable[[GroundMaps], bytes]


def save(
    prediction: GroundMaps,
    folder: Path,
    formats: Sequence[str],
    *,
    name: str | None = None,
    overwrite: bool = False,
) -> list[Path]:
    """Writes the files of a prediction; see `Prediction.save`.

    Each file is written atomically: it appears whole or not at all.
    """
    stem = name or prediction.name or NAMELESS
    targets = output_paths(folder, stem, formats)
    refuse_overwriting(targets, {real_path(prediction.path)} if prediction.path else set())
    existing = [] if overwrite else [path for path in targets if _exists(path)]
    if existing:
        raise OutputError(
            f"existing results: {', '.join(map(str, existing))}; nothing was written; "
            "pass overwrite=True, or another folder or name"
        )
    written: list[Path] = []
    write(prediction, targets, written.append)
    return written


def write(
    prediction: GroundMaps,
    targets: Mapping[Path, Encoder],
    report: Callable[[Path], None] = lambda _: None,
) -> None:
    """Writes the given files of a prediction and replaces existing ones.

    A file that cannot be made does not stop the others; the first reason is raised in the end. Of
    `png16`, maps that the model file lacks are left out.

    Args:
        prediction: The prediction.
        targets: The files and their encoders.
        report: Called with each file as soon as it is there.

    Raises:
        OutputError: If a folder or a file cannot be written.
        FootprintsError: If the prediction has no such result, such as a map without ground.
    """
    first: Exception | None = None
    for path, encode in targets.items():
        try:
            write_atomically(path, encode(prediction))
        except MissingMapError as error:
            if not path.name.endswith(tuple(FORMATS["png16"])):
                first = first or error
        except (OSError, ValueError) as error:  # ValueError: a null byte in the name
            reason = getattr(error, "strerror", None) or error
            failed = OutputError(f"cannot write {path}: {reason}")
            failed.__cause__ = error
            first = first or failed
        except Exception as error:
            first = first or error
        else:
            report(path)
    if first is not None:
        raise first


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError) as error:  # such as a name that is too long
        reason = getattr(error, "strerror", None) or error
        raise OutputError(f"cannot write {path}: {reason}") from error


def output_paths(folder: Path, name: str, formats: Iterable[str]) -> Mapping[Path, Encoder]:
    """The output files of `formats`, in order, with their encoders.

    File names begin with the picture's full name, so `a.jpg` and `a.png` never collide.

    Raises:
        OutputError: If a format is unknown, no format is given, or the name is a path.
    """
    wanted = list(dict.fromkeys([formats] if isinstance(formats, str) else formats))
    unknown = [key for key in wanted if key not in FORMATS]
    if unknown or not wanted:
        raise OutputError(
            f"unknown output format {', '.join(unknown) or '(none given)'}; "
            f"choose from {', '.join(FORMATS)}"
        )
    if Path(name).name != name or "\0" in name:
        raise OutputError(f"the name {name!r} is a path; give the folder separately")
    files = (item for wanted_format in wanted for item in FORMATS[wanted_format].items())
    return {
        folder / (name + suffix): encode
        if encode is not _map_yaml
        else partial(_map_yaml, image=name + _MAP_PNG)
        for suffix, encode in files
    }


def refuse_overwriting(targets: Iterable[Path], pictures: Set[Path]) -> None:
    """Checks that no output replaces an input picture; `pictures` are resolved paths.

    Raises:
        OutputError: If an output is one of the pictures.
    """
    for path in targets:
        if real_path(path) in pictures:
            raise OutputError(f"{path} is an input picture; choose another folder or name")


def _overlay(prediction: GroundMaps) -> bytes:
    from footprints_edge.drawing.overlay import encode_overlay

    return encode_overlay(prediction)


def _npz(prediction: GroundMaps) -> bytes:
    """Maps that the model file lacks are left out."""
    camera = prediction.intrinsics
    buffer = io.BytesIO()
    names = ["visible_depth_m"] if prediction.has("visible_depth_m") else []
    if prediction.has("ground_probability"):
        names += ["visible_ground", "ground", "hidden_ground"]
        names += ["visible_ground_probability", "ground_probability"]
    if {"ground", "visible_depth_m"} <= set(names):
        names.append("ground_depth_m")
    arrays = {name: getattr(prediction, name) for name in names}
    if {"ground_depth_m", "visible_ground"} <= set(names):
        confidence = prediction.confidence
        arrays["confidence"] = np.array([confidence.ground, confidence.metres])
    np.savez_compressed(
        buffer,
        **arrays,
        image_size=np.array(prediction.image_size),
        intrinsics=np.array([camera.fx, camera.fy, camera.cx, camera.cy]),
    )
    return buffer.getvalue()


def _json(prediction: GroundMaps) -> bytes:
    from footprints_edge.outputs.json_summary import summarise

    return (json.dumps(summarise(prediction), indent=2, allow_nan=False) + "\n").encode("ascii")


def _ply(prediction: GroundMaps) -> bytes:
    from footprints_edge.outputs.ply import encode_ply

    return encode_ply(prediction)


def _top_down_picture(prediction: GroundMaps) -> bytes:
    from footprints_edge.drawing.notes import lens_note
    from footprints_edge.drawing.occupancy_grid import encode_occupancy_grid
    from footprints_edge.navigation.occupancy_grid import usual_grid

    return encode_occupancy_grid(usual_grid(prediction), lens_note(prediction.intrinsics.source))


def _map_png(prediction: GroundMaps) -> bytes:
    from footprints_edge.navigation.occupancy_grid import usual_grid

    return usual_grid(prediction).map_png()


def _map_yaml(prediction: GroundMaps, image: str = NAMELESS + _MAP_PNG) -> bytes:
    """The YAML refers to the picture beside it."""
    from footprints_edge.navigation.occupancy_grid import usual_grid

    return usual_grid(prediction).map_yaml(image)


def _grid_npz(prediction: GroundMaps) -> bytes:
    from footprints_edge.outputs.occupancy_files import encode_occupancy_npz

    return encode_occupancy_npz(prediction)


def _grid_ply(prediction: GroundMaps) -> bytes:
    from footprints_edge.outputs.occupancy_files import encode_occupancy_ply

    return encode_occupancy_ply(prediction)


def _depth_png(depth_m: Floats) -> bytes:
    """uint16 millimetres; 0 means no depth, so depths are at least 1 mm."""
    valid = np.isfinite(depth_m)
    millimetres = np.clip(np.rint(1000 * np.where(valid, depth_m, 0)), valid, FARTHEST_MM)
    return encode_png(Image.fromarray(millimetres.astype(np.uint16)))


def _mask_png(mask: Mask) -> bytes:
    """8-bit grey: 255 where True, 0 elsewhere."""
    return encode_png(Image.fromarray(np.where(mask, np.uint8(255), np.uint8(0))))


FORMATS: Mapping[str, Mapping[str, Encoder]] = {
    "overlay": {".overlay.png": _overlay},
    "npz": {".npz": _npz},
    "png16": {
        ".visible_depth_mm.png": lambda prediction: _depth_png(prediction.visible_depth_m),
        ".ground_depth_mm.png": lambda prediction: _depth_png(prediction.ground_depth_m),
        ".visible_ground.png": lambda prediction: _mask_png(prediction.visible_ground),
        ".ground.png": lambda prediction: _mask_png(prediction.ground),
        ".hidden_ground.png": lambda prediction: _mask_png(prediction.hidden_ground),
    },
    "json": {".json": _json},
    "ply": {".ply": _ply},
    "topdown": {_MAP_PNG: _map_png, ".topdown.yaml": _map_yaml},
    "topdown_npz": {".topdown.npz": _grid_npz},
    "topdown_ply": {".topdown.ply": _grid_ply},
    "topdown_picture": {".topdown_picture.png": _top_down_picture},
}
"""The files of each format: the suffix of the picture's name, and the encoder."""

OUTPUT_ENDINGS = tuple(suffix for files in FORMATS.values() for suffix in files)
"""Suffixes of our own outputs, which are never read as input pictures."""
