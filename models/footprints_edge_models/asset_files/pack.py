"""All assets in one file: read once from their sources, then by key, quickly, by many processes.

A pack is a zip, stored without compression: `index.json`, and for each model and world an `.npz`,
for each texture and panorama its JPEG. Points are kept as uint16 within their surface's box, a
texture that several surfaces share once. Models are ready to be placed: simplified, and vehicles
turned so that their length lies along y.
"""

import hashlib
import io
import json
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge_models.asset_files.asset import (
    LONGEST_TEXTURE_PX,
    Asset,
    AssetError,
    Credit,
    Surface,
)
from footprints_edge_models.asset_files.glb import Viewpoint, World, read_objects, read_world
from footprints_edge_models.asset_files.outlines import VEHICLES, outlines_of
from footprints_edge_models.asset_files.pictures import (
    HELD_OUT_PANORAMAS,
    PictureFile,
    panorama_files,
    texture_files,
)
from footprints_edge_models.asset_files.simplify import simplified
from footprints_edge_models.asset_files.sweet_home import SweetHomeCatalogue
from footprints_edge_models.asset_files.world_plan import TakenGround, WorldPlan

FORMAT = 2
MOST_TRIANGLES = 4000
"""Triangles of a model: enough for a thing that fills a third of a picture 448 pixels wide."""
STILL_TOO_MANY = 5
"""A model that keeps this many times the triangles, a tree of single leaves, is left out."""
TEXTURE_PX = 256
"""Longest side of a model's texture: scenes draw no larger ones."""
HELD_OUT_WORLDS = frozenset({"classroom", "bookstore", "city-south"})
HELD_OUT_EVERY = 8
"""One model and texture in eight is for the test split, chosen by its key."""

INTERIOR, TOWN = "interior", "town"
"""Categories of worlds."""

_JPEG_QUALITY = 90

Kind: TypeAlias = Literal["model", "world", "texture", "panorama"]
Split: TypeAlias = Literal["train", "test"]


@dataclass(frozen=True)
class PackEntry:
    """One asset of a pack.

    Attributes:
        kind: What it is.
        key: Unique name within its kind.
        name: In words.
        category: Group that its source puts it in; of a texture its class, of a panorama its
            setting.
        size_m: (width, depth, height) of a model; zeros else.
        triangles: How many it has.
        stands: Whether a model takes ground; one that hangs on a wall does not.
        credit: Whom to credit.
    """

    kind: Kind
    key: str
    name: str
    category: str
    size_m: tuple[float, float, float]
    triangles: int
    credit: Credit
    stands: bool = True

    @property
    def split(self) -> Split:
        """The split that it belongs to; no asset belongs to both."""
        if self.kind == "world":
            return "test" if self.key in HELD_OUT_WORLDS else "train"
        if self.kind == "panorama":
            return "test" if self.key in HELD_OUT_PANORAMAS else "train"
        return "test" if zlib.crc32(self.key.encode()) % HELD_OUT_EVERY == 0 else "train"


@dataclass
class PackReport:
    """What went into a pack.

    Attributes:
        counts: How many of each kind.
        skipped: Why assets are not in it, one message each.
    """

    counts: dict[str, int] = field(default_factory=dict)
    skipped: list[str] = field(default_factory=list)


def pack_assets(
    folders: Sequence[Path],
    path: Path,
    progress: Callable[[str], None] = lambda _: None,
    *,
    most_triangles: int = MOST_TRIANGLES,
    texture_px: int = TEXTURE_PX,
) -> PackReport:
    """Reads every asset below some folders and writes them into one file.

    Found are Sweet Home 3D catalogues (`*.sh3f`), folders of GLB objects with an `index.json`,
    worlds (`NAME.glb` with `NAME.cameras.json`), and folders of textures and panoramas with an
    `index.json`. An asset that cannot be used is left out; the report says why.

    Args:
        folders: Where to look.
        path: The pack.
        progress: Called with the key of every asset.
        most_triangles: A model with more is simplified.
        texture_px: Longest side of the models' textures; of the worlds', where less than theirs.

    Raises:
        AssetError: If a folder does not exist or nothing usable is found.
    """
    report = PackReport()
    entries: list[PackEntry] = []
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for found in _found(folders):
            if isinstance(found, AssetError):
                report.skipped.append(str(found))
                continue
            try:
                entry, name, data = _encoded(found, most_triangles, texture_px)
            except AssetError as error:
                report.skipped.append(str(error))
                continue
            if name in archive.NameToInfo:
                report.skipped.append(f"{entry.kind} {entry.key}: there is another of this name")
                continue
            progress(entry.key)
            archive.writestr(name, data)
            entries.append(entry)
            report.counts[entry.kind] = report.counts.get(entry.kind, 0) + 1
        index = {"format": FORMAT, "entries": [asdict(entry) for entry in entries]}
        archive.writestr("index.json", json.dumps(index, indent=1))
    if not entries:
        raise AssetError(f"{', '.join(map(str, folders))}: no asset found; {report.skipped[:3]}")
    write_atomically(path, buffer.getvalue())
    return report


def _found(folders: Sequence[Path]) -> Iterator[Asset | World | PictureFile | AssetError]:
    for folder in folders:
        if not folder.is_dir():
            raise AssetError(f"{folder}: no such folder of assets")
        for path in sorted(folder.rglob("*.sh3f")):
            yield from _catalogue(path)
        for path in sorted(folder.rglob("*.cameras.json")):
            glb = path.with_name(path.name.removesuffix(".cameras.json") + ".glb")
            try:
                yield read_world(glb)
            except AssetError as error:
                yield error
        for path in sorted(folder.rglob("index.json")):
            yield from _indexed(path)


def _catalogue(path: Path) -> Iterator[Asset | AssetError]:
    try:
        with SweetHomeCatalogue(path) as catalogue:
            yield from catalogue.damaged
            for entry in catalogue.entries:
                try:
                    yield catalogue.read(entry)
                except AssetError as error:
                    yield error
    except AssetError as error:
        yield error


def _indexed(path: Path) -> Iterator[Asset | PictureFile | AssetError]:
    """What an `index.json` lists: objects, textures or panoramas, told apart by their facts."""
    try:
        facts = json.loads(path.read_text(encoding="utf-8"))
        first = facts[0]
        if "projection" in first:
            yield from panorama_files(path)
        elif "cls" in first:
            yield from texture_files(path)
        elif "category" in first:
            yield from read_objects(path.parent)
        else:
            yield AssetError(f"{path} lists neither objects, nor textures, nor panoramas")
    except (OSError, ValueError, LookupError, TypeError) as error:
        yield AssetError(f"{path} is not an index of assets: {error!r}")


def _encoded(
    found: Asset | World | PictureFile, most_triangles: int, texture_px: int
) -> tuple[PackEntry, str, bytes]:
    if isinstance(found, PictureFile):
        entry = PackEntry(
            found.kind, found.key, found.name, found.category, (0.0, 0.0, 0.0), 0, found.credit
        )
        return entry, f"{found.kind}s/{found.key}.jpg", found.jpeg
    if isinstance(found, World):
        triangles = sum(len(surface.triangles) for surface in found.surfaces)
        entry = PackEntry(
            "world",
            found.key,
            found.credit.title,
            INTERIOR if found.core_m is None else TOWN,
            (0.0, 0.0, 0.0),
            triangles,
            found.credit,
        )
        extra: dict[str, NDArray[Any]] = {
            "eyes": np.array([view.eye_m for view in found.viewpoints], np.float32),
            "looks": np.array([view.look_m for view in found.viewpoints], np.float32),
            "heights": np.array([view.height_m for view in found.viewpoints], np.float32),
            "core": np.array(found.core_m or (), np.float64),
            "names": np.array([surface.name for surface in found.surfaces]),
            **_plan_arrays(found.plan),
        }
        longest = texture_px if texture_px < TEXTURE_PX else LONGEST_TEXTURE_PX
        return entry, f"worlds/{found.key}.npz", _npz(found.surfaces, longest, extra)
    if all(surface.alpha is not None for surface in found.surfaces):
        raise AssetError(f"{found.key}: all of it has holes, as leaves have")
    if found.category in VEHICLES:
        found = found.lengthwise()
    outlines = outlines_of(found.surfaces, found.category)
    surfaces = simplified(found.surfaces, most_triangles)
    triangles = sum(len(surface.triangles) for surface in surfaces)
    if triangles > STILL_TOO_MANY * most_triangles:
        raise AssetError(f"{found.key}: {triangles} triangles, and they cannot be simplified")
    extra = {
        "outline_points": np.concatenate([np.zeros((0, 2)), *outlines]).astype(np.float32),
        "outline_lengths": np.array([len(outline) for outline in outlines], np.int32),
    }
    entry = PackEntry(
        "model",
        found.key,
        found.name,
        found.category,
        found.size_m,
        triangles,
        found.credit,
        stands=bool(outlines),
    )
    return entry, f"models/{found.key}.npz", _npz(surfaces, texture_px, extra)


def _plan_arrays(plan: WorldPlan) -> dict[str, NDArray[Any]]:
    outlines = [each.outline for each in plan.taken]
    return {
        "thing_of": np.array(plan.thing_of, np.int32),
        "storeys_m": np.array(plan.storeys_m, np.float64),
        "taken_by": np.array([each.thing for each in plan.taken], np.int32),
        "taken_level_m": np.array([each.level_m for each in plan.taken], np.float32),
        "outline_points": np.concatenate([np.zeros((0, 2)), *outlines]).astype(np.float32),
        "outline_lengths": np.array([len(outline) for outline in outlines], np.int32),
    }


def _plan(arrays: Any) -> WorldPlan:  # noqa: ANN401 - a file of numpy's
    ends = np.cumsum(arrays["outline_lengths"])
    outlines = np.split(arrays["outline_points"].astype(np.float64), ends)[:-1]
    by, levels = arrays["taken_by"].tolist(), arrays["taken_level_m"].tolist()
    return WorldPlan(
        tuple(arrays["thing_of"].tolist()),
        tuple(map(TakenGround, by, levels, outlines)),
        tuple(arrays["storeys_m"].tolist()),
    )


def _npz(surfaces: Sequence[Surface], longest_px: int, extra: dict[str, NDArray[Any]]) -> bytes:
    """The arrays of all surfaces, one after the other: few arrays are read faster than many."""
    boxes, points, uv, textures = [], [], [], []
    arrays = dict(extra)
    distinct: dict[bytes, int] = {}
    for surface in surfaces:
        low = surface.points.min(axis=0)
        step = np.maximum(np.ptp(surface.points, axis=0), 1e-6) / 65535
        points.append(np.rint((surface.points - low) / step).astype(np.uint16))
        boxes.append((low, step))
        if surface.texture is None:
            textures.append(-1)
            continue
        uv.append(surface.uv)
        alpha = surface.alpha
        same = surface.texture.tobytes() + (b"" if alpha is None else alpha.tobytes())
        if same not in distinct:
            arrays |= _texture(len(distinct), surface.texture, alpha, longest_px)
        textures.append(distinct.setdefault(same, len(distinct)))
    triangles = [surface.triangles for surface in surfaces]
    highest = max(map(len, points), default=0)
    arrays |= {
        "boxes": np.array(boxes, np.float32).reshape(-1, 2, 3),
        "points": np.concatenate(points),
        "point_counts": np.array([len(each) for each in points], np.int32),
        "triangles": np.concatenate(triangles).astype(np.uint16 if highest <= 65536 else np.uint32),
        "triangle_counts": np.array([len(each) for each in triangles], np.int32),
        "uv": np.concatenate([np.zeros((0, 2), np.float32), *uv]),
        "rgb": np.array([surface.rgb for surface in surfaces], np.uint8),
        "textures": np.array(textures, np.int32),
        "roles": np.array([surface.role for surface in surfaces]),
    }
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]
    return buffer.getvalue()


def _texture(
    number: int, texture: NDArray[np.uint8], alpha: NDArray[np.bool_] | None, longest_px: int
) -> dict[str, NDArray[Any]]:
    """One texture and its alpha as arrays of a pack, neither side longer than `longest_px`."""
    height, width = texture.shape[:2]
    size = (min(width, longest_px), min(height, longest_px))
    if size != (width, height):
        texture = np.asarray(cv2.resize(texture, size, interpolation=cv2.INTER_AREA), np.uint8)
    arrays: dict[str, NDArray[Any]] = {f"texture{number}": _jpeg(texture)}
    if alpha is not None:
        opaque = cv2.resize(alpha.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0.5
        arrays[f"alpha{number}"] = np.packbits(opaque, axis=1)
    return arrays


def _jpeg(texture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    bgr = cv2.cvtColor(np.ascontiguousarray(texture), cv2.COLOR_RGB2BGR)
    good, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    assert good
    return np.asarray(data, np.uint8).ravel()


def decode_jpeg(data: bytes | NDArray[np.uint8]) -> NDArray[np.uint8]:
    """uint8 (H, W, 3), RGB."""
    bgr = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)


class AssetPack:
    """An open pack. Reading keeps no state but the file: each process opens its own."""

    def __init__(self, path: Path) -> None:
        """Opens a pack.

        Raises:
            AssetError: If it is missing, damaged or of another format.
        """
        self.path = path
        try:
            self._zip = zipfile.ZipFile(path)
            index = json.loads(self._zip.read("index.json"))
        except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
            raise AssetError(f"{path} is not a pack of assets: {error}") from error
        if index.get("format") != FORMAT:
            raise AssetError(
                f"{path} has format {index.get('format')!r}, this version reads {FORMAT}; pack the "
                "assets again"
            )
        self.entries = [_entry(facts) for facts in index["entries"]]

    @cached_property
    def fingerprint(self) -> str:
        """Changes with the assets: from their names, sizes and checksums in the zip."""
        facts = [(info.filename, info.file_size, info.CRC) for info in self._zip.infolist()]
        return hashlib.sha256(repr(facts).encode()).hexdigest()[:16]

    def of(self, kind: Kind, split: Split) -> list[PackEntry]:
        """The entries of one kind that belong to a split, in order."""
        return [entry for entry in self.entries if (entry.kind, entry.split) == (kind, split)]

    def model(self, entry: PackEntry) -> Asset:
        """A model's triangles."""
        with np.load(io.BytesIO(self._zip.read(f"models/{entry.key}.npz"))) as arrays:
            surfaces = tuple(_surfaces(arrays))
            ends = np.cumsum(arrays["outline_lengths"])[:-1]
            outlines = tuple(np.split(arrays["outline_points"].astype(np.float64), ends))
        return Asset(
            entry.key,
            entry.name,
            entry.category,
            entry.size_m,
            surfaces,
            entry.credit,
            outlines if len(outlines[0]) else (),
        )

    def world(self, entry: PackEntry) -> World:
        """A world's triangles and viewpoints."""
        with np.load(io.BytesIO(self._zip.read(f"worlds/{entry.key}.npz"))) as arrays:
            views = zip(arrays["eyes"], arrays["looks"], arrays["heights"], strict=True)
            core = tuple(float(side) for side in arrays["core"])
            return World(
                entry.key,
                tuple(
                    replace(surface, name=str(name))
                    for surface, name in zip(_surfaces(arrays), arrays["names"], strict=True)
                ),
                tuple(Viewpoint(eye, look, float(height)) for eye, look, height in views),
                (core[0], core[1], core[2], core[3]) if core else None,
                entry.credit,
                _plan(arrays),
            )

    def picture(self, entry: PackEntry) -> NDArray[np.uint8]:
        """A texture or a panorama, uint8 (H, W, 3), RGB."""
        return decode_jpeg(self._zip.read(f"{entry.kind}s/{entry.key}.jpg"))


def _entry(facts: dict[str, Any]) -> PackEntry:
    width, depth, height = facts.pop("size_m")
    return PackEntry(
        **facts | {"size_m": (width, depth, height), "credit": Credit(**facts["credit"])}
    )


def _surfaces(arrays: Any) -> Iterator[Surface]:  # noqa: ANN401 - a file of numpy's
    """The surfaces; those of one texture hold the same array."""
    boxes, roles, rgb, textures = (arrays[name] for name in ("boxes", "roles", "rgb", "textures"))
    points = np.split(arrays["points"], np.cumsum(arrays["point_counts"])[:-1])
    triangles = np.split(
        arrays["triangles"].astype(np.int32), np.cumsum(arrays["triangle_counts"])[:-1]
    )
    uv, used = arrays["uv"], 0
    drawn = [_drawn(arrays, number) for number in range(int(textures.max(initial=-1)) + 1)]
    for number, role in enumerate(roles):
        low, step = boxes[number]
        own_points = (points[number] * step + low).astype(np.float32)
        own_uv = np.zeros((len(own_points), 2), np.float32)
        texture = alpha = None
        if textures[number] >= 0:
            texture, alpha = drawn[textures[number]]
            own_uv = uv[used : used + len(own_points)]
            used += len(own_points)
        red, green, blue = (int(value) for value in rgb[number])
        yield Surface(
            own_points, triangles[number], own_uv, (red, green, blue), texture, alpha, str(role)
        )


def _drawn(
    arrays: Any,  # noqa: ANN401 - a file of numpy's
    number: int,
) -> tuple[NDArray[np.uint8], NDArray[np.bool_] | None]:
    texture = decode_jpeg(arrays[f"texture{number}"])
    if f"alpha{number}" not in arrays:
        return texture, None
    bits = np.unpackbits(arrays[f"alpha{number}"], axis=1)[:, : texture.shape[1]]
    return texture, bits.astype(bool)
