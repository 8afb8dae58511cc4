"""What is fuzzed: for each kind of file, sound files to spoil, and what must hold for any other.

A check returns, or raises what is no error of the package: then it has failed. That the process
dies or does not come back is for `run.py` to see.
"""

import io
import pickle
import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from edits import edited_bytes, edited_message, edited_text, edited_zip
from hypothesis import strategies as st
from PIL import Image
from PIL.ExifTags import IFD, Base

import footprints_edge as fp
from footprints_edge.errors import FootprintsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.calibration import Calibration
from footprints_edge.inputs.images import DecodedImage, decode

warnings.filterwarnings("ignore", module=r"PIL\.")  # as the command does

PICTURE = np.random.default_rng(0).integers(0, 256, (24, 40, 3), np.uint8)
LONGEST_MESSAGE = 5000


@dataclass(frozen=True)
class Target:
    """A kind of file.

    Attributes:
        check: Raises what must not be raised.
        spoiled: A function that makes the strategy of inputs.
    """

    check: Callable[[bytes], None]
    spoiled: Callable[[], st.SearchStrategy[bytes]]


@contextmanager
def typed_errors() -> Iterator[None]:
    """Errors of the package are good answers, if they fit on a screen."""
    try:
        yield
    except FootprintsError as error:
        message = str(error)
        assert message, "an error without a message"
        assert len(message) < LONGEST_MESSAGE, f"a message of {len(message)} characters"
        assert message.replace("\n", "").replace("\t", "").isprintable(), repr(message[:500])


@contextmanager
def file_of(data: bytes, name: str) -> Iterator[Path]:
    """A file with these bytes."""
    with tempfile.TemporaryDirectory(prefix="fp-fuzz-") as folder:
        path = Path(folder, name)
        path.write_bytes(data)
        yield path


def saved(mode: str, kind: str, **options: Any) -> bytes:
    """A small picture in a format."""
    buffer = io.BytesIO()
    image = Image.fromarray(PICTURE).convert("L" if mode in {"F", "I;16"} else mode)
    if mode in {"F", "I;16"}:
        image = Image.fromarray(np.asarray(image).astype(np.float32 if mode == "F" else np.uint16))
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def exif_block(**more: Any) -> bytes:
    """An EXIF block that states an orientation and a focal length."""
    exif = Image.Exif()
    exif[Base.Orientation] = 6
    facts = {
        Base.FocalLengthIn35mmFilm: 28,
        Base.FocalLength: 4.25,
        Base.ExifImageWidth: 40,
        Base.ExifImageHeight: 24,
        **more,
    }
    exif.get_ifd(IFD.Exif).update(facts)
    return exif.tobytes()


def check_picture(data: bytes) -> None:
    """Any picture is decoded to upright RGB, or refused."""
    with typed_errors():
        picture = decode(data, lambda _: (16, 16))
        assert picture.pixels.dtype == np.uint8
        assert picture.pixels.ndim == 3 and picture.pixels.shape[2] == 3
        assert min(picture.size) >= 1
        assert all(map(str.isprintable, picture.notes))
        if picture.focal_35mm is not None:
            Intrinsics.from_focal_35mm(picture.focal_35mm, picture.size)


def check_exif(data: bytes) -> None:
    """No EXIF block spoils a picture: its metadata counts as absent."""
    whole = saved("RGB", "JPEG")
    block = b"Exif\0\0" + data.removeprefix(b"Exif\0\0")[:60_000]
    length = (len(block) + 2).to_bytes(2, "big")
    picture = decode(whole[:2] + b"\xff\xe1" + length + block + whole[2:])
    assert picture.size in {(24, 40), (40, 24)}
    if picture.focal_35mm is not None:
        camera = Intrinsics.from_focal_35mm(picture.focal_35mm, picture.size)
        assert 0.5 < camera.focal_px < 1e5, camera


def check_model(data: bytes) -> None:
    """Any model file gives maps from 0 to 1 of the right size in both engines, or is refused."""
    picture = np.tile(PICTURE, (3, 3, 1))
    with file_of(data, "model.onnx") as path:
        for engine in _engines():
            with typed_errors():
                model = fp.load(path, threads=1, engine=engine)
                prediction = model.predict(picture)
                assert prediction.map_size == model.input_size(prediction.image_size)
                for name in ("ground_probability", "visible_ground_probability"):
                    if prediction.has(name):
                        values = getattr(prediction, name)
                        assert 0 <= values.min() <= values.max() <= 1
                for name in ("visible_depth_m", "unmasked_ground_depth_m"):
                    if prediction.has(name):
                        values = getattr(prediction, name)
                        assert np.isfinite(values).all() and values.min() > 0


@cache
def _engines() -> tuple[str, ...]:
    from importlib.util import find_spec

    return ("onnxruntime", "openvino") if find_spec("openvino") else ("onnxruntime",)


def check_checkpoint(data: bytes) -> None:
    """Any checkpoint fills a network with plain numbers, or is refused; it runs no code."""
    from footprints_edge_models.networks.checkpoint import (
        load_weights,
        read_checkpoint,
        stated_focal_px,
    )

    with file_of(data, "model.pth") as path, typed_errors():
        weights = read_checkpoint(path)
        stated_focal_px(weights, path.name)
        network = _network()
        load_weights(network, weights, path.name)
        for tensor in network.state_dict().values():
            assert tensor.device.type == "cpu"
            tensor.sum().item()


def _network() -> Any:
    import torch

    return torch.nn.Sequential(torch.nn.Conv2d(3, 4, 1), torch.nn.BatchNorm2d(4))


def _checkpoint(weights: Any, **options: Any) -> bytes:
    import torch

    buffer = io.BytesIO()
    torch.save(weights, buffer, **options)
    return buffer.getvalue()


@st.composite
def odd_checkpoints(draw: Any) -> bytes:
    """Checkpoints with sound bytes and odd tensors or keys."""
    import torch

    torch.manual_seed(0)
    weights = dict(_network().state_dict())
    key = draw(st.sampled_from(sorted(weights)))
    odd = {
        "meta": lambda t: t.to("meta"),
        "sparse": lambda t: t.float().to_sparse(),
        "complex": lambda t: t.to(torch.complex64),
        "quantised": lambda t: torch.quantize_per_tensor(t.float(), 0.1, 0, torch.qint8),
        "bool": lambda t: t > 0,
        "float8": lambda t: t.to(torch.float8_e4m3fn),
        "huge": lambda _: torch.zeros(1).expand(10**6, 10**6),
        "nested": lambda t: torch.nested.nested_tensor([t.float(), t.float()]),
        "text": lambda _: "x",
        "list": lambda _: [1],
    }
    how = draw(st.sampled_from([*odd, "key", "wrapped", "deep", "focal"]))
    if how in odd:
        with suppress(NotImplementedError, RuntimeError):
            weights[key] = odd[how](weights[key])
    elif how == "key":
        name = draw(st.one_of(st.text(max_size=20), st.just("k" * 10**5)))
        weights[name] = weights.pop(key)
    elif how == "focal":
        stated = draw(st.one_of(st.floats(), st.just([1.0, 2.0]), st.just([])))
        weights["canonical_focal_px"] = torch.tensor(stated)
    elif how == "deep":
        for _ in range(draw(st.sampled_from([3, 100, 900]))):
            weights = [weights]
    else:
        weights = {"state_dict": weights}
    with suppress(RecursionError, NotImplementedError, RuntimeError, pickle.PicklingError):
        return _checkpoint(weights)
    return b""


def check_calibration(data: bytes) -> None:
    """Any calibration rectifies a picture of its shape, or is refused."""
    with file_of(data, "camera.yaml") as path, typed_errors():
        calibration = Calibration.read(path)
        height, width = calibration.size
        small = (
            max(1, height * 40 // max(height, width)),
            max(1, width * 40 // max(height, width)),
        )
        picture = DecodedImage(np.zeros((*small, 3), np.uint8))
        rectified, camera = calibration.rectified(picture)
        assert rectified.size == small
        assert np.isfinite(camera.matrix).all()


CALIBRATIONS = (
    """image_width: 40
image_height: 24
camera_name: narrow
camera_matrix:
  rows: 3
  cols: 3
  data: [ 30.0, 0.0, 19.5, 0.0, 30.0, 11.5, 0.0, 0.0, 1.0 ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [ -0.2, 0.05, 0.001, 0.001, 0.0 ]
""",
    """%YAML:1.0
---
image_width: 40
image_height: 24
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 30., 0., 19.5, 0., 30., 11.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 4
   cols: 1
   dt: d
   data: [ 0.01, -0.002, 0.001, 0. ]
fisheye_model: 1
""",
)

POSES = ("1 0 0 0.5 0 1 0 0.25 0 0 1 1.5", "1 0 0 1 0 1 0 0.25 0 0 1 1.5")
"""Camera to world, 3 x 4."""

SEQUENCES = (
    """== rgb.txt
# colour
1.00 rgb/1.png
1.20 rgb/2.png
== depth.txt
1.01 depth/1.png
1.21 depth/2.png
== groundtruth.txt
1.00 0.5 0.25 1.5 0 0 0 1
1.20 1.0 0.25 1.5 0 0 0 1
== calibration.txt
30 30 19.5 11.5
""",
    f"""== sequence.json
{{ "intrinsics": [[ 30, 0, 19.5 ], [ 0, 30, 11.5 ], [ 0, 0, 1 ]],
"gravity_direction": [ 0, 0, -1 ], "depth_unit": "mm",
"frames": [ {{ "name": "1", "camera_to_world": [ {", ".join(POSES[0].split())} ] }},
{{ "name": "2", "camera_to_world": [ {", ".join(POSES[1].split())} ] }} ] }}
""",
    """== cameras.txt
3 PINHOLE 40 24 30 30 20 12
4 SIMPLE_RADIAL 40 24 30 20 12 0
== images.txt
1 1 0 0 0 0.5 0.25 1.5 3 1.png

2 1 0 0 0 1.0 0.25 1.5 4 2.png
1.5 2.5 -1
""",
    """== pose/1.txt
1 0 0 0.5
0 1 0 0.25
0 0 1 1.5
0 0 0 1
== pose/31.txt
1 0 0 1
0 1 0 0.25
0 0 1 1.5
0 0 0 1
== intrinsic/intrinsic_color.txt
30 0 19.5 0
0 30 11.5 0
0 0 1 0
0 0 0 1
== color/1.jpg
== color/31.jpg
== depth/31.png
""",
    f"""== calib.txt
30 0 19.5 0 0 30 11.5 0 0 0 1 0
30 0 19.5 -3.6 0 30 11.5 0 0 0 1 0
== poses.txt
{POSES[0]}
{POSES[1]}
== image_l/1.png
== image_l/2.png
== image_r/1.png
== image_r/2.png
""",
    """== odometry.csv
timestamp, frame, x, y, z, qx, qy, qz, qw
1.00, 1, 0.5, 0.25, 1.5, 0, 0, 0, 1
1.20, 2, 1.0, 0.25, 1.5, 0, 0, 0, 1
== camera_matrix.csv
30, 0, 19.5
0, 30, 11.5
0, 0, 1
== rgb.mp4
""",
)
"""Files of a folder, one after the other; pictures of every layout are there already."""


def check_sequence(data: bytes) -> None:
    """Any sequence has finite poses and names that stay inside a folder, or is refused."""
    from footprints_edge_models.sequences.layouts import read_sequence

    with tempfile.TemporaryDirectory(prefix="fp-fuzz-") as scratch:
        folder = Path(scratch, "clip")
        shutil.copytree(_pictures(), folder)
        for part in b"\n".join([b"", data]).split(b"\n== ")[1:]:
            name, _, content = part.partition(b"\n")
            path = folder / name.decode("utf-8", "replace").replace("\0", "")
            with suppress(OSError):  # names that no file can have, too
                if not path.resolve().is_relative_to(folder) or path.is_dir():
                    continue
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content or path.read_bytes() if path.exists() else content)
        with typed_errors():
            sequence = read_sequence(folder)
            for frame in sequence.frames:
                assert np.isfinite(frame.camera_to_world).all()
                assert frame.intrinsics.fx > 0
                assert (folder / frame.name).resolve().is_relative_to(folder.resolve())
            assert np.isfinite(sequence.up).all()


def check_pack(data: bytes) -> None:
    """Any pack of assets gives triangles of points that are there, or is refused."""
    from footprints_edge_models.asset_files.pack import AssetPack

    with file_of(data, "assets.zip") as path, typed_errors():
        pack = AssetPack(path)
        for entry in pack.entries:
            with typed_errors():
                if entry.kind in {"texture", "panorama"}:
                    assert pack.picture(entry).ndim == 3
                    continue
                for surface in getattr(pack, entry.kind)(entry).surfaces:
                    assert np.isfinite(surface.points).all()
                    assert surface.uv.shape == (len(surface.points), 2)
                    if len(surface.triangles):
                        low, high = surface.triangles.min(), surface.triangles.max()
                        assert 0 <= low <= high < len(surface.points)


def check_views(data: bytes) -> None:
    """Any shard of a kit gives views of one size, or is refused."""
    from footprints_edge_models.training.gpu_kit.view_shard import read_shard

    with file_of(data, "views.zip") as path, typed_errors():
        for each in read_shard(path, threads=1):
            height, width = each.view.size
            assert each.view.depths_m.shape == (height, width, 2)
            assert np.isfinite(each.view.depths_m).all()


def _pack() -> bytes:
    """A model with a texture, a world, a texture and a panorama."""
    import json

    import trimesh

    from footprints_edge_models.asset_files.pack import pack_assets

    credit = {"licence": "CC0-1.0", "author": "Somebody", "source": "somewhere"}
    camera = {"position": [1, 1.5, -2], "look_at": [0, 1, 0], "eye_height": 1.5}
    things = {"file": "car.glb", "category": "car", "size": [2, 1, 4], "nodes": [], **credit}
    texture = {"file": "one.jpg", "cls": "woodfloor", "use": "floor", **credit}
    panorama = {"projection": "equirectangular", "shows": "a room", "setting": "indoor"}
    nodes = [{"name": "body", "role": "wall"}]
    described = {
        "objects/index.json": [things | {"nodes": [{"name": "body"}]}],
        "worlds/hall.json": {"title": "A hall", "nodes": nodes, **credit},
        "worlds/hall.cameras.json": {"cameras": [camera]},
        "textures/index.json": [texture],
        "panoramas/index.json": [{"file": "one.jpg", **panorama, **credit}],
    }
    with tempfile.TemporaryDirectory(prefix="fp-fuzz-") as scratch:
        folder = Path(scratch)
        for name, facts in described.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(json.dumps(facts))
        for name, size in (("objects/car", (2, 1, 4)), ("worlds/hall", (6, 3, 8))):
            mesh = trimesh.creation.box(size)
            mesh.apply_translation((0, size[1] / 2, 0))
            uv = mesh.vertices[:, :2]
            mesh.visual = trimesh.visual.TextureVisuals(uv, image=Image.fromarray(PICTURE))
            scene = trimesh.Scene()
            scene.add_geometry(mesh, node_name="body", geom_name="body")
            (folder / f"{name}.glb").write_bytes(scene.export(file_type="glb"))
        for name in ("textures", "panoramas"):
            Image.fromarray(PICTURE).save(folder / name / "one.jpg")
        report = pack_assets([folder], folder / "assets.zip")
        assert len(report.counts) == 4, report
        return (folder / "assets.zip").read_bytes()


def _views() -> bytes:
    from footprints_edge_models.training.gpu_kit.stored_view import StoredView
    from footprints_edge_models.training.gpu_kit.view_shard import ShardView, write_shard

    pixels = np.dstack([PICTURE, PICTURE[..., 0] & 63])
    view = StoredView(pixels, np.full((24, 40, 2), 2.5, np.float16), (30.0, 30.0, 19.5, 11.5))
    with tempfile.TemporaryDirectory(prefix="fp-fuzz-") as scratch:
        path = Path(scratch, "views.zip")
        write_shard(path, [ShardView(view, "photos", "train")] * 2)
        return path.read_bytes()


@cache
def _pictures() -> Path:
    """A folder with the pictures that the sequences name."""
    folder = Path(tempfile.mkdtemp(prefix="fp-fuzz-pictures-"))
    for name in ("rgb/1.png", "rgb/2.png", "images/1.png", "images/2.png"):
        (folder / name).parent.mkdir(exist_ok=True)
        Image.fromarray(PICTURE).save(folder / name)
    for name in ("depth/1.png", "depth/2.png"):
        (folder / name).parent.mkdir(exist_ok=True)
        Image.fromarray(np.full((24, 40), 2000, np.uint16)).save(folder / name)
    return folder


def _pictures_to_spoil() -> st.SearchStrategy[bytes]:
    exif = exif_block()
    seeds = [
        saved("RGB", "JPEG"),
        saved("RGB", "JPEG", progressive=True, exif=exif),
        saved("CMYK", "JPEG"),
        saved("RGB", "PNG"),
        saved("P", "PNG", transparency=3),
        saved("RGBA", "PNG", icc_profile=b"x" * 200, exif=exif),
        saved("I;16", "PNG"),
        saved("1", "PNG"),
        saved("RGB", "WEBP"),
        saved("RGBA", "WEBP", lossless=True),
        saved("F", "TIFF"),
        saved("RGB", "TIFF", compression="tiff_adobe_deflate"),
        saved("RGB", "BMP"),
        saved("P", "BMP"),
    ]
    return edited_bytes(seeds)


def _models_to_spoil() -> st.SearchStrategy[bytes]:
    import onnx
    from tiny_model import tiny_model_bytes

    small = tiny_model_bytes()
    bundled = fp.load(threads=1).path.read_bytes()
    return st.one_of(
        edited_message(onnx.load_from_string(small)),
        edited_message(onnx.load_from_string(small)),
        edited_bytes([small, tiny_model_bytes((32, 64))]),
        edited_message(onnx.load_from_string(bundled)),
    )


def _checkpoints_to_spoil() -> st.SearchStrategy[bytes]:
    weights = _network().state_dict()
    seeds = [_checkpoint(weights), _checkpoint(weights, _use_new_zipfile_serialization=False)]
    return st.one_of(edited_bytes(seeds), odd_checkpoints())


TARGETS = {
    "pictures": Target(check_picture, _pictures_to_spoil),
    "exif": Target(check_exif, lambda: edited_bytes([exif_block()])),
    "models": Target(check_model, _models_to_spoil),
    "checkpoints": Target(check_checkpoint, _checkpoints_to_spoil),
    "calibrations": Target(check_calibration, lambda: edited_text(CALIBRATIONS)),
    "sequences": Target(check_sequence, lambda: edited_text(SEQUENCES)),
    "packs": Target(check_pack, lambda: edited_zip(_pack())),
    "views": Target(check_views, lambda: edited_zip(_views())),
}
