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
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

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
from footprints_edge_models.bounded_files import (
    MOST_BYTES,
    decode_picture,
    read_arrays,
    refuse_packed,
)

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
_Arrays: TypeAlias = Mapping[str, NDArray[Any]]


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


def _plan(arrays: _Arrays, surfaces: int) -> WorldPlan:
    by, levels = arrays["taken_by"].tolist(), arrays["taken_level_m"].tolist()
    thing_of = tuple(arrays["thing_of"].tolist())
    if len(thing_of) != surfaces:
        raise ValueError(f"the things of {len(thing_of)} surfaces, there are {surfaces}")
    return WorldPlan(
        thing_of,
        tuple(TakenGround(*taken) for taken in zip(by, levels, _outlines(arrays), strict=True)),
        tuple(arrays["storeys_m"].tolist()),
    )


def _outlines(arrays: _Arrays) -> list[NDArray[np.float64]]:
    points = arrays["outline_points"].astype(np.float64)
    return _parts(points.reshape(-1, 2), arrays["outline_lengths"])


def _parts(values: NDArray[Any], lengths: NDArray[Any]) -> list[NDArray[Any]]:
    """Rows one after the other as the arrays that they were, all of which are there."""
    if lengths.min(initial=0) < 0 or lengths.sum() != len(values):
        raise ValueError(f"{lengths.sum()} rows are stated, there are {len(values)}")
    return np.split(values, np.cumsum(lengths))[:-1]


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
    """uint8 (H, W, 3), RGB.

    Raises:
        ValueError: It is damaged.
    """
    return np.asarray(cv2.cvtColor(decode_picture(data), cv2.COLOR_BGR2RGB), np.uint8)


class AssetPack:
    """An open pack. Reading keeps no state but the file: each process opens its own."""

    def __init__(self, path: Path) -> None:
        """Opens a pack.

        Raises:
            AssetError: If it is missing, damaged or of another format.
        """
        self.path = path
        try:
            refuse_packed(path)  # packs are stored
            self._zip = zipfile.ZipFile(path)
            index = json.loads(self._zip.read("index.json"))
            stated = index.get("format")
            self.entries = [_entry(facts) for facts in index["entries"]] if stated == FORMAT else []
        except Exception as error:  # damaged bytes make the readers raise nearly anything
            raise AssetError(f"{path} is not a pack of assets: {_said(error)}") from error
        if stated != FORMAT:
            raise AssetError(
                f"{path} has format {stated!r:.100}, this version reads {FORMAT}; pack the assets "
                "again"
            )

    @cached_property
    def fingerprint(self) -> str:
        """Changes with the assets: from their names, sizes and checksums in the zip."""
        facts = [(info.filename, info.file_size, info.CRC) for info in self._zip.infolist()]
        return hashlib.sha256(repr(facts).encode()).hexdigest()[:16]

    def of(self, kind: Kind, split: Split) -> list[PackEntry]:
        """The entries of one kind that belong to a split, in order."""
        return [entry for entry in self.entries if (entry.kind, entry.split) == (kind, split)]

    def model(self, entry: PackEntry) -> Asset:
        """A model's triangles.

        Raises:
            AssetError: If it is missing or damaged.
        """
        with self._reading(f"models/{entry.key}.npz") as data:
            arrays = _arrays(data)
            return Asset(
                entry.key,
                entry.name,
                entry.category,
                entry.size_m,
                tuple(_surfaces(arrays)),
                entry.credit,
                tuple(_outlines(arrays)),
            )

    def world(self, entry: PackEntry) -> World:
        """A world's triangles and viewpoints.

        Raises:
            AssetError: If it is missing or damaged.
        """
        with self._reading(f"worlds/{entry.key}.npz") as data:
            arrays = _arrays(data)
            surfaces = tuple(_surfaces(arrays))
            eyes, looks = arrays["eyes"].reshape(-1, 3), arrays["looks"].reshape(-1, 3)
            views = zip(eyes, looks, arrays["heights"], strict=True)
            core = tuple(float(side) for side in arrays["core"])
            return World(
                entry.key,
                tuple(
                    replace(surface, name=str(name))
                    for surface, name in zip(surfaces, arrays["names"], strict=True)
                ),
                tuple(Viewpoint(eye, look, float(height)) for eye, look, height in views),
                (core[0], core[1], core[2], core[3]) if core else None,
                entry.credit,
                _plan(arrays, len(surfaces)),
            )

    def picture(self, entry: PackEntry) -> NDArray[np.uint8]:
        """A texture or a panorama, uint8 (H, W, 3), RGB.

        Raises:
            AssetError: If it is missing or damaged.
        """
        with self._reading(f"{entry.kind}s/{entry.key}.jpg") as data:
            return decode_jpeg(data)

    @contextmanager
    def _reading(self, name: str) -> Iterator[bytes]:
        """The bytes of a file in the pack; what goes wrong with them names it."""
        try:
            yield self._zip.read(name)
        except Exception as error:  # damaged bytes make the readers raise nearly anything
            raise AssetError(
                f"{self.path}: {name!r:.200} is missing or damaged ({_said(error)}); pack the "
                "assets again"
            ) from error


def _said(error: Exception) -> str:
    """What it says, printable: it may cite the file."""
    return "".join(c if c.isprintable() else " " for c in f"{error!s:.300}")


def _entry(facts: dict[str, Any]) -> PackEntry:
    width, depth, height = map(float, facts["size_m"])
    entry = PackEntry(
        **facts | {"size_m": (width, depth, height), "credit": Credit(**facts["credit"])}
    )
    texts = (entry.key, entry.name, entry.category, *vars(entry.credit).values())
    if entry.kind not in get_args(Kind) or not all(isinstance(text, str) for text in texts):
        raise ValueError(f"no asset: {entry}")
    if not (np.isfinite(entry.size_m).all() and min(entry.size_m) >= 0):
        raise ValueError(f"{entry.key}: {entry.size_m} m large")
    return entry


def _arrays(data: bytes) -> _Arrays:
    """The arrays of a model or a world.

    Raises:
        ValueError: They are damaged, or one holds a number that is none.
    """
    arrays = read_arrays(data)
    for name, array in arrays.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise ValueError(f"{name} is not finite")
    return arrays


def _surfaces(arrays: _Arrays) -> Iterator[Surface]:
    """The surfaces; those of one texture hold the same array.

    Raises:
        ValueError: Their numbers lead nowhere: code in C++ would follow them.
    """
    boxes, roles, rgb, textures = (arrays[name] for name in ("boxes", "roles", "rgb", "textures"))
    points = _parts(arrays["points"].reshape(-1, 3), arrays["point_counts"])
    triangles = _parts(
        arrays["triangles"].astype(np.int32).reshape(-1, 3), arrays["triangle_counts"]
    )
    for ours, theirs in zip(points, triangles, strict=True):
        if len(theirs) and not 0 <= theirs.min() <= theirs.max() < len(ours):
            raise ValueError(f"a triangle of vertex {theirs.max()}, there are {len(ours)}")
    uv, used = arrays["uv"].reshape(-1, 2), 0
    drawn, taken = [], 0
    for number in range(int(textures.max(initial=-1)) + 1):
        drawn.append(_drawn(arrays, number))
        taken += drawn[-1][0].nbytes
        if taken > MOST_BYTES:
            raise ValueError(f"its textures take more than {MOST_BYTES} bytes")
    for number, role in enumerate(roles):
        low, step = boxes[number]
        own_points = (points[number] * step + low).astype(np.float32)
        own_uv = np.zeros((len(own_points), 2), np.float32)
        texture = alpha = None
        if textures[number] >= 0:
            texture, alpha = drawn[textures[number]]
            own_uv = uv[used : used + len(own_points)]
            used += len(own_points)
        if own_uv.shape != (len(own_points), 2) or not np.isfinite(own_points).all():
            raise ValueError(f"surface {number}: vertices without a place")
        red, green, blue = (int(value) for value in rgb[number])
        yield Surface(
            own_points, triangles[number], own_uv, (red, green, blue), texture, alpha, str(role)
        )


def _drawn(arrays: _Arrays, number: int) -> tuple[NDArray[np.uint8], NDArray[np.bool_] | None]:
    texture = decode_jpeg(arrays[f"texture{number}"])
    if f"alpha{number}" not in arrays:
        return texture, None
    bits = np.unpackbits(arrays[f"alpha{number}"], axis=1)[:, : texture.shape[1]]
    if bits.shape != texture.shape[:2]:
        raise ValueError(f"texture {number}: its holes are of another size")
    return texture, bits.astype(bool)
