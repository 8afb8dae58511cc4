"""Whole places from files: their floors, and the things in them, ready for scenes.

Faces of floors that look up are walkable; their sides are kerbs, which are not. Stairs are things:
a robot on wheels does not walk their steps.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.asset import Surface
from footprints_edge_models.asset_files.glb import Viewpoint, World
from footprints_edge_models.asset_files.pack import PackEntry
from footprints_edge_models.asset_files.world_plan import VEHICLE_WORDS, has_word
from footprints_edge_models.scenes.assets.materials import Material
from footprints_edge_models.scenes.assets.models import smooth_normals
from footprints_edge_models.scenes.assets.pack_part import PackPart
from footprints_edge_models.scenes.assets.shapes import Shape
from footprints_edge_models.scenes.assets.textures.library import TextureKey
from footprints_edge_models.scenes.assets.textures.noise import SIDE_PX
from footprints_edge_models.scenes.assets.things import Thing, ThingPart
from footprints_edge_models.scenes.rendering.raycast import Triangles
from footprints_edge_models.scenes.vectors import cross

WALKABLE = 0.7
"""A face of a floor is walkable if its unit normal's z is larger."""
KERB_M = 0.03
"""A side of a floor that is lower, such as a rug's, is walkable, too."""

MOST_LOADED = 14
"""Worlds that a process keeps in memory; each takes about 25 MB."""
_STANDS_WITHIN_M = 0.03
_SMALL_M, _NEAR_M = 0.4, np.float32(0.06)
_ASIDE = np.concatenate([np.eye(3), -np.eye(3)]).astype(np.float32)
_MOVABLE_M = {False: (2.3, 2.3), True: (7.5, 12.0)}
"""Greatest length and height of what can be moved away; by whether it is outdoors."""
_LABELS = (
    ("office chair", ("officechair",)), ("chair", ("chair", "seat")), ("stool", ("stool",)),
    ("bed", ("bed",)), ("sofa", ("sofa", "couch")), ("desk", ("desk",)), ("table", ("table",)),
    ("television", ("tv", "television", "monitor")), ("fridge", ("refrigerator", "fridge")),
    ("shelf", ("shelf", "rack")), ("door", ("door",)), ("window", ("window",)),
    ("cabinet", ("cabinet", "wardrobe", "nightstand", "drawer", "dresser")),
    ("tree", ("tree",)), ("pole", ("pole", "post", "sign", "hydrant")),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class WorldFloor:
    """A walkable surface of a world.

    Attributes:
        name: of its node.
        part: its faces that look up, with its own material.
        bare: the same without texture coordinates: they are metres along x and y.
        area_m2: how large it is.
    """

    name: str
    part: ThingPart
    bare: Shape = field(repr=False)
    area_m2: float


@dataclass(frozen=True, eq=False)
class WorldThing:
    """A thing of a world.

    Attributes:
        thing: where it stands.
        low_m: least corner (3,) of the box around it.
        high_m: greatest corner.
        movable: whether it can be taken away alone.
    """

    thing: Thing
    low_m: NDArray[np.float64]
    high_m: NDArray[np.float64]
    movable: bool


@dataclass(frozen=True, eq=False)
class LoadedWorld:
    """A world in memory.

    Attributes:
        key: its name.
        floors: its walkable surfaces.
        kerbs: their sides.
        things: everything else in it.
        taken: ground that nobody can reach, and ground taken on upper storeys: things without
            parts.
        viewpoints: where cameras may stand.
        core_m: (x0, y0, x1, y1) of a town's built part; None indoors.
        textures: of its surfaces, by number.
    """

    key: str
    floors: tuple[WorldFloor, ...]
    kerbs: tuple[ThingPart, ...]
    things: tuple[WorldThing, ...]
    taken: tuple[Thing, ...]
    viewpoints: tuple[Viewpoint, ...]
    core_m: tuple[float, float, float, float] | None
    textures: dict[int, NDArray[np.uint8]] = field(repr=False)

    @property
    def outdoors(self) -> bool:
        """Whether it is a town."""
        return self.core_m is not None

    @cached_property
    def floor_triangles(self) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """The corners of all floors, (T, 3, 3), and the floor of each triangle, (T,)."""
        corners = [floor.bare.corners for floor in self.floors]
        owners = np.repeat(np.arange(len(corners)), [len(each) for each in corners])
        return np.concatenate(corners), owners.astype(np.int32)

    @cached_property
    def thing_triangles(self) -> NDArray[np.float32]:
        """The corners of all things and kerbs, (T, 3, 3)."""
        found = [part.shape.corners for part in self.kerbs]
        found += [part.shape.corners for each in self.things for part in each.thing.parts]
        return np.concatenate([np.zeros((0, 3, 3), np.float32), *found])


class WorldLibrary(PackPart):
    """The worlds of a pack that belong to one split."""

    @cached_property
    def entries(self) -> list[PackEntry]:
        """The worlds of the split."""
        return self._pack.of("world", self.split)

    def load(self, key: str) -> LoadedWorld:
        """A world; the last few stay in memory."""
        entry = next(entry for entry in self.entries if entry.key == key)
        return self._keep(key, lambda: loaded(self._pack.world(entry)), MOST_LOADED)

    def texture(self, key: TextureKey) -> NDArray[np.uint8]:
        """The texture of a world's surface, uint8 (SIDE_PX, SIDE_PX, 3), RGB."""
        return self.load(key.kind.removeprefix("world:")).textures[key.number]


def loaded(world: World) -> LoadedWorld:
    """A world as scenes need it."""
    numbers = _texture_numbers(world.surfaces)
    textures = {
        number: _square(world.surfaces[number]) for number in dict.fromkeys(numbers) if number >= 0
    }
    floors, kerbs, things = [], [], []
    members: dict[int, list[ThingPart]] = {}
    names: dict[int, Surface] = {}
    for surface, number, owner in zip(world.surfaces, numbers, world.plan.thing_of, strict=True):
        material = _material(world.key, surface, number)
        if surface.role == "floor":
            top, sides = _split(surface)
            if top is not None:
                floors.append(_floor(top, material))
            if sides is not None:
                kerbs.append(_part(sides, material))
            continue
        members.setdefault(owner, []).append(_part(surface, material))
        names.setdefault(owner, surface)
    afloat = _floating(world, members)
    outlines: dict[tuple[int, float], list[NDArray[np.float64]]] = {}
    for each in world.plan.taken:
        if each.thing not in afloat:
            outlines.setdefault((each.thing, each.level_m), []).append(each.outline)
    for owner, parts in members.items():
        if owner in afloat:
            continue
        levels = [level for thing, level in outlines if thing == owner]
        level = levels[0] if levels else 0.0
        thing = Thing(
            _label(names[owner]),
            tuple(parts),
            tuple(outlines.pop((owner, level), ())),
            is_wall=names[owner].role == "wall",
            asset=world.key,
            level_m=level,
        )
        things.append(
            _world_thing(thing, names[owner].role == "object", outdoors=world.core_m is not None)
        )
    taken = tuple(
        Thing("taken ground", (), tuple(rings), is_wall=True, level_m=level)
        for (_, level), rings in outlines.items()
    )
    return LoadedWorld(
        world.key,
        tuple(floors),
        tuple(kerbs),
        tuple(things),
        taken,
        world.viewpoints,
        world.core_m,
        textures,
    )


def _floating(world: World, owners: Iterable[int]) -> set[int]:
    """Small things that touch nothing: what was in glasses that the world's file leaves out."""
    corners = [surface.points[surface.triangles] for surface in world.surfaces]
    owner_of = np.repeat(np.array(world.plan.thing_of), [len(each) for each in corners])
    tracer = Triangles(np.concatenate(corners))
    found = set()
    for owner in owners:
        own = np.concatenate([corners[k] for k, o in enumerate(world.plan.thing_of) if o == owner])
        points = own.reshape(-1, 3)
        if np.ptp(points, axis=0).max() > _SMALL_M:
            continue
        points = points[:: max(1, len(points) // 120)]
        ways = np.repeat(_ASIDE, len(points), axis=0)
        starts = np.tile(points, (len(_ASIDE), 1)) - ways * _NEAR_M / 4
        hits = tracer.first_hits(starts.astype(np.float32), ways)
        near = (hits.triangle >= 0) & (hits.distance < _NEAR_M)
        if not (near & (owner_of[hits.triangle] != owner)).any():
            found.add(owner)
    return found


def _texture_numbers(surfaces: tuple[Surface, ...]) -> list[int]:
    """A number for each surface's texture, the same for the same one; -1 without one."""
    known: dict[int, int] = {}
    return [
        -1 if s.texture is None else known.setdefault(id(s.texture), k)
        for k, s in enumerate(surfaces)
    ]


def _square(surface: Surface) -> NDArray[np.uint8]:
    """A surface's texture, with the mean colour where it is not opaque."""
    texture = np.array(surface.texture)
    if surface.alpha is not None and surface.alpha.any():
        texture[~surface.alpha] = texture[surface.alpha].mean(axis=0)
    return np.asarray(
        cv2.resize(texture, (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA), np.uint8
    )


def _split(surface: Surface) -> tuple[Surface | None, Surface | None]:
    """The walkable faces of a floor, and its kerbs; undersides are left out."""
    corners = surface.points[surface.triangles].astype(np.float64)
    across = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    rise = across[:, 2] / np.maximum(np.linalg.norm(across, axis=1), 1e-12)
    low = np.ptp(corners[..., 2], axis=1) < KERB_M
    top = (rise > WALKABLE) | ((np.abs(rise) <= WALKABLE) & low)
    return _some(surface, top), _some(surface, ~top & (rise >= -WALKABLE))


def _some(surface: Surface, which: NDArray[np.bool_]) -> Surface | None:
    if not which.any():
        return None
    used, triangles = np.unique(surface.triangles[which], return_inverse=True)
    return Surface(
        surface.points[used],
        triangles.reshape(-1, 3).astype(np.int32),
        surface.uv[used],
        surface.rgb,
        surface.texture,
        surface.alpha,
        surface.role,
        surface.name,
    )


def _floor(surface: Surface, material: Material) -> WorldFloor:
    part = _part(surface, material)
    corners = part.shape.corners.astype(np.float64)
    across = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area_m2 = float(np.linalg.norm(across, axis=1).sum() / 2)
    return WorldFloor(surface.name, part, _without_uv(part.shape), area_m2)


def _without_uv(shape: Shape) -> Shape:
    return Shape(shape.corners, shape.normals, shape.convex, None, shape.mesh)


def _part(surface: Surface, material: Material) -> ThingPart:
    """A surface as it is placed in its world."""
    uv = surface.uv[surface.triangles] * np.array([1, -1], np.float32)
    shape = Shape(
        surface.points[surface.triangles],
        smooth_normals(surface),
        convex=False,
        uv=uv * np.float32(material.tile_m),
        mesh=(surface.points.astype(np.float64), surface.triangles),
        opaque=surface.alpha,
    )
    return ThingPart(shape, np.eye(3, 4), material)


def _material(key: str, surface: Surface, number: int) -> Material:
    """Its own texture, whose repeats are as long as they are on the surface, or its colour."""
    linear = (np.array(surface.rgb) / 255) ** 2.2
    gloss = (0.0, 0.0, 0.04, 0.1)[sum(surface.name.encode()) % 4]
    if surface.role == "floor":
        gloss = 0.0  # drawn for each scene
    if number >= 0:
        red, green, blue = (float(value) for value in linear)
        texture = TextureKey(f"world:{key}", number)
        return Material(texture, _tile_m(surface), (red, green, blue), gloss)
    red, green, blue = (float(value) for value in linear / 0.8**2.2)  # of the blank's grey
    return Material(TextureKey("blank", 2), 1.0, (red, green, blue), gloss)


def _tile_m(surface: Surface) -> float:
    """Metres that one repeat of its texture takes, on average."""
    corners, uv = surface.points[surface.triangles], surface.uv[surface.triangles]
    sides = (corners[:, 1:] - corners[:, :1]).astype(np.float64)
    area = np.linalg.norm(cross(sides[:, 0], sides[:, 1]), axis=1).sum()
    one, two = ((uv[:, k] - uv[:, 0]).astype(np.float64) for k in (1, 2))
    in_repeats = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]).sum()
    return float(np.clip(np.sqrt(area / max(in_repeats, 1e-9)), 0.02, 50.0))


def _world_thing(thing: Thing, loose: bool, *, outdoors: bool = False) -> WorldThing:
    low, high = thing.extent
    length, height = _MOVABLE_M[outdoors]
    size = high - low
    stands = abs(low[2] - thing.level_m) < _STANDS_WITHIN_M and bool(thing.outlines)
    small = size[:2].max() < length and size[2] < height
    return WorldThing(thing, low, high, loose and stands and bool(small))


def _label(surface: Surface) -> str:
    if surface.role in {"wall", "stairs"}:
        return surface.role
    if has_word(surface.name, VEHICLE_WORDS):
        return "car"
    name = surface.name.lower()
    return next(
        (label for label, words in _LABELS if any(word in name for word in words)), "object"
    )
