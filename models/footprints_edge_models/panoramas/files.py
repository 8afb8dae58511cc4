"""Views of panoramas on disk: a JPEG and a PNG of labels each, and ``panoramas.json``.

``panoramas.json`` names the views and their cameras. It is written last: a folder without it is
not finished.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import IntrinsicsError
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.panoramas.labels import PanoramaError
from footprints_edge_models.panoramas.views import PanoramaView

MANIFEST = "panoramas.json"
FORMAT = 1
_JPEG_QUALITY = 95


@dataclass(frozen=True)
class ViewFile:
    """One view of a folder.

    Attributes:
        name: the panorama's name, an underscore, and a number.
        image: its picture.
        labels: its labels, a PNG.
        intrinsics: in pixels of the picture.
    """

    name: str
    image: Path
    labels: Path
    intrinsics: Intrinsics = field(repr=False)

    def read_bits(self) -> NDArray[np.uint8]:
        """Labels, uint8 (H, W): see :mod:`panoramas.labels`.

        Raises:
            PanoramaError: they are missing or damaged.
        """
        bits = cv2.imread(str(self.labels), cv2.IMREAD_GRAYSCALE)
        if bits is None:
            raise PanoramaError(f"{self.labels}: no readable labels; make them again")
        return np.asarray(bits, np.uint8)


def view_name(panorama: str, number: int) -> str:
    """The name of a panorama's view."""
    return f"{panorama}_{number:03d}"


def write_view(folder: Path, name: str, view: PanoramaView) -> dict[str, Any]:
    """Writes a view's picture and labels; returns its entry for :func:`write_manifest`."""
    flags = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    bgr = cv2.cvtColor(view.image, cv2.COLOR_RGB2BGR)
    write_atomically(_image(folder, name), cv2.imencode(".jpg", bgr, flags)[1].tobytes())
    write_atomically(_labels(folder, name), cv2.imencode(".png", view.bits)[1].tobytes())
    camera = view.camera
    return {
        "name": name,
        "size": list(camera.size),
        "focal_px": round(camera.intrinsics.focal_px, 3),
        "heading_deg": round(camera.heading_deg, 2),
        "pitch_deg": round(camera.pitch_deg, 2),
        "roll_deg": round(camera.roll_deg, 2),
    }


def begin(folder: Path) -> None:
    """Marks a folder as unfinished: views that are made anew may differ from those it lists."""
    (folder / MANIFEST).unlink(missing_ok=True)


def write_manifest(folder: Path, seed: int, entries: Sequence[dict[str, Any]]) -> None:
    """Writes the list of views: the folder is finished."""
    about = {"format": FORMAT, "seed": seed, "views": list(entries)}
    write_atomically(folder / MANIFEST, (json.dumps(about, indent=1) + "\n").encode())


def read_views(folder: Path) -> list[ViewFile]:
    """The views of a folder, by name.

    Raises:
        PanoramaError: it was not finished, or another version wrote it.
    """
    path = folder / MANIFEST
    try:
        about = json.loads(path.read_text(encoding="utf-8"))
        if about["format"] != FORMAT:
            raise PanoramaError(f"{path}: format {about['format']}, this version reads {FORMAT}")
        return [
            ViewFile(
                entry["name"],
                _image(folder, entry["name"]),
                _labels(folder, entry["name"]),
                Intrinsics.from_focal_px(
                    entry["focal_px"], (int(entry["size"][0]), int(entry["size"][1]))
                ),
            )
            for entry in sorted(about["views"], key=lambda entry: str(entry["name"]))
        ]
    except (OSError, ValueError, KeyError, TypeError, IndexError, IntrinsicsError) as error:
        raise PanoramaError(
            f"{path}: no readable list of views ({error}); make them: fp-train panoramas"
        ) from error


def _image(folder: Path, name: str) -> Path:
    return folder / "images" / f"{name}.jpg"


def _labels(folder: Path, name: str) -> Path:
    return folder / "labels" / f"{name}.png"
