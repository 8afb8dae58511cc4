"""Furniture catalogues of Sweet Home 3D: `.sh3f`, a zip of models and a table about them.

The format: https://www.sweethome3d.com/blog/2011/09/22/how_to_create_a_sh3f_file.html. Debian's
package `sweethome3d-furniture` installs five of them below /usr/share/sweethome3d/furniture.
"""

import io
import posixpath
import re
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.asset import Asset, AssetError, Credit, Surface
from footprints_edge_models.asset_files.meshes import check_mesh, surfaces_of

TABLE = "PluginFurnitureCatalog.properties"

MOST_MODEL_BYTES = 16_000_000
MOST_TRIANGLES = 160_000
"""Finer models take longer to read and simplify than they are worth."""

_ESCAPE = re.compile(r"\\u([0-9a-fA-F]{4})")

_LICENCES = {
    "creative commons attribution 3.0": "CC-BY-3.0",
    "creative commons attribution 4.0": "CC-BY-4.0",
    "licenses/by/3.0": "CC-BY-3.0",
    "licenses/by/4.0": "CC-BY-4.0",
    "public domain": "CC0-1.0",
    "cc0": "CC0-1.0",
    "cc-0": "CC0-1.0",
}
"""Words in a catalogue's licence, and the licence that they stand for. The text of CC BY speaks of
the public domain as well: that comes last."""
_BANS = ("noncommercial", "non-commercial", "noderiv", "sharealike", "share alike", "by-sa")


@dataclass(frozen=True)
class CatalogueEntry:
    """One line of a catalogue.

    Attributes:
        catalogue: The file.
        model: The model's path in it.
        key: Unique name.
        name: What it is.
        category: The catalogue's group.
        size_m: (width, depth, height).
        elevation_m: Height of its underside above the floor.
        rotation: (3, 3), turns the model before it is scaled; None if it stands as it should.
        is_opening: Whether it is a door or a window.
        credit: Whom to credit.
    """

    catalogue: Path
    model: str
    key: str
    name: str
    category: str
    size_m: tuple[float, float, float]
    elevation_m: float
    rotation: NDArray[np.float64] | None
    is_opening: bool
    credit: Credit


class SweetHomeCatalogue:
    """An open catalogue; use it as a context manager.

    Attributes:
        path: The file.
        entries: Its models.
        damaged: Why lines of its table are not among them.
    """

    def __init__(self, path: Path) -> None:
        """Opens the file and reads its table.

        Raises:
            AssetError: If it is not a catalogue, or its licence does not allow its use.
        """
        self.path = path
        try:
            self._zip = zipfile.ZipFile(path)
            lines = self._zip.read(TABLE).decode("latin-1").splitlines()
        except (OSError, KeyError, zipfile.BadZipFile) as error:
            raise AssetError(f"{path} is not a Sweet Home 3D catalogue: {error}") from error
        self._names = {name.lower(): name for name in self._zip.namelist()}
        properties = dict(_properties(lines))
        licence = self._licence(properties)
        title = properties.get("name", path.stem)
        numbers = [key[6:] for key in properties if key.startswith("model#")]
        self.entries: list[CatalogueEntry] = []
        self.damaged: list[AssetError] = []
        for number in numbers:
            try:
                self.entries.append(_entry(path, properties, number, title, licence))
            except (KeyError, ValueError) as error:
                self.damaged.append(AssetError(f"{path.stem}, entry {number}: {error!r}"))

    def __enter__(self) -> "SweetHomeCatalogue":
        return self

    def __exit__(self, *_: object) -> None:
        self._zip.close()

    def _licence(self, properties: Mapping[str, str]) -> str:
        """The licence, from the table or from the text that lies beside it.

        Raises:
            AssetError: If it is none of those that allow anyone to use and pass on the models.
        """
        said = [properties.get("license", "")]
        if "license.txt" in self._names:
            said.append(self._zip.read(self._names["license.txt"]).decode("latin-1"))
        for text in said:
            words = " ".join(text.lower().split())
            if any(ban in words for ban in _BANS):
                break
            for phrase, licence in _LICENCES.items():
                if phrase in words:
                    return licence
        raise AssetError(
            f"{self.path}: its licence is none of CC0 and CC BY; models under other licences "
            "are not used, because weights trained on them could not be shipped"
        )

    def read(self, entry: CatalogueEntry) -> Asset:
        """The model of one entry, in the size that the catalogue states.

        Raises:
            AssetError: If the model is missing, damaged, too large or empty.
        """
        import trimesh

        try:
            info = self._zip.getinfo(entry.model)
        except KeyError as error:
            raise AssetError(f"{entry.key}: {entry.model} is not in {self.path.name}") from error
        if info.file_size > MOST_MODEL_BYTES:
            raise AssetError(f"{entry.key}: {info.file_size} bytes, more than {MOST_MODEL_BYTES}")
        kind = entry.model.rpartition(".")[2].lower()
        resolver = _Resolver(self._zip, self._names, posixpath.dirname(entry.model))
        try:
            scene = trimesh.load_scene(
                io.BytesIO(self._zip.read(info)), file_type=kind, resolver=resolver, process=False
            )
        except Exception as error:  # trimesh's readers raise nearly anything on odd files
            raise AssetError(f"{entry.key}: {entry.model} cannot be read: {error}") from error
        meshes = [mesh for mesh in scene.geometry.values() if len(getattr(mesh, "faces", ()))]
        if not meshes:
            raise AssetError(f"{entry.key}: {entry.model} has no triangles")
        count = sum(len(mesh.faces) for mesh in meshes)
        if count > MOST_TRIANGLES:
            raise AssetError(f"{entry.key}: {count} triangles, more than {MOST_TRIANGLES}")
        for mesh in meshes:
            check_mesh(mesh, np.asarray(mesh.vertices), f"{entry.key}: {entry.model}")
        placed = _placed([np.asarray(mesh.vertices, np.float64) for mesh in meshes], entry)
        surfaces: list[Surface] = []
        for mesh, points in zip(meshes, placed, strict=True):
            surfaces += surfaces_of(mesh, points)
        return Asset(
            entry.key, entry.name, entry.category, entry.size_m, tuple(surfaces), entry.credit
        )


def _placed(
    vertices: list[NDArray[np.float64]], entry: CatalogueEntry
) -> list[NDArray[np.float64]]:
    """Vertices turned, scaled to the catalogue's size, centred, and set on their elevation."""
    if entry.rotation is not None:
        vertices = [points @ entry.rotation.T for points in vertices]
    every = np.concatenate(vertices)
    low, high = every.min(axis=0), every.max(axis=0)
    width, depth, height = entry.size_m
    scale = np.array([width, height, depth]) / np.maximum(high - low, 1e-9)
    underside = np.array([0.0, entry.elevation_m + height / 2, 0.0])
    return [(points - (low + high) / 2) * scale + underside for points in vertices]


def _properties(lines: list[str]) -> Iterator[tuple[str, str]]:
    for line in lines:
        key, equals, value = line.partition("=")
        if equals and not line.lstrip().startswith(("#", "!")):
            yield key.strip(), _ESCAPE.sub(lambda found: chr(int(found[1], 16)), value.strip())


def _entry(
    path: Path, properties: Mapping[str, str], number: str, title: str, licence: str
) -> CatalogueEntry:
    def stated(key: str, otherwise: str = "") -> str:
        return properties.get(f"{key}#{number}", otherwise)

    rotation = stated("modelRotation").split()
    name = stated("name", "thing")
    return CatalogueEntry(
        catalogue=path,
        model=stated("model").lstrip("/"),
        key=f"{path.stem}/{stated('id', number).rpartition('#')[2]}",
        name=name,
        category=stated("category"),
        size_m=(
            float(properties[f"width#{number}"]) / 100,
            float(properties[f"depth#{number}"]) / 100,
            float(properties[f"height#{number}"]) / 100,
        ),
        elevation_m=float(stated("elevation", "0")) / 100,
        rotation=np.array(rotation, np.float64).reshape(3, 3) if len(rotation) == 9 else None,
        is_opening=stated("doorOrWindow") == "true",
        credit=Credit(name, stated("creator", "unknown"), licence, f"Sweet Home 3D, {title}"),
    )


class _Resolver(Mapping[str, bytes]):
    """Files beside a model in its zip, in upper or lower case; one of trimesh's resolvers."""

    def __init__(self, archive: zipfile.ZipFile, names: Mapping[str, str], folder: str) -> None:
        self._zip, self._names, self._folder = archive, names, folder

    def __getitem__(self, name: str) -> bytes:
        """The bytes of a material or an image.

        Raises:
            KeyError: If there is none of that name.
        """
        wanted = posixpath.normpath(posixpath.join(self._folder, name.replace("\\", "/"))).lower()
        if wanted not in self._names:
            ending = "/" + posixpath.basename(wanted)
            wanted = next((key for key in self._names if key.endswith(ending)), wanted)
        return self._zip.read(self._names[wanted])

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
