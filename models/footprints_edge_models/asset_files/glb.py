"""GLB objects and whole worlds, described by JSON files beside them.

A folder of objects holds `index.json`: a list of objects with `file`, `category`, `licence`,
`author`, `source` and `nodes`. A world `NAME.glb` has `NAME.json`, with `title`, `licence`,
`author`, `source` and `nodes`, and `NAME.cameras.json`, with places where a camera stands free.
Nodes have a `name`, and where they need them a `role` (`floor`, `wall`, `object`, `door_open`,
`backdrop`), `rgb` (sRGB), `alpha_mask`, and `stairs`. Metres, y up.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.asset import (
    Asset,
    AssetError,
    Credit,
    Surface,
    free_licence,
    upright,
)
from footprints_edge_models.asset_files.meshes import check_mesh, surfaces_of
from footprints_edge_models.asset_files.world_plan import WorldPlan, plan_of

_ROLES = {"floor": "floor", "wall": "wall", "object": "object", "door_open": "object"}
"""Roles of nodes that are kept, and what they are to a scene. Others, bright planes outside windows
(`backdrop`), are left out: the sky is seen there."""


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A place in a world where a camera stands free.

    Attributes:
        eye_m: float32 (3,), in the axes of scenes.
        look_m: float32 (3,), a point that it looks at.
        height_m: Of the eye above the floor below it.
    """

    eye_m: NDArray[np.float32]
    look_m: NDArray[np.float32]
    height_m: float


@dataclass(frozen=True, eq=False)
class World:
    """A furnished place as a whole.

    Attributes:
        key: Unique name, that of its file.
        surfaces: Its triangles by node, with their roles.
        viewpoints: Where cameras may stand.
        core_m: (x0, y0, x1, y1) of the part that is built, of places outdoors; None is indoors.
        credit: Whom to credit.
        plan: What stands where on its floors.
    """

    key: str
    surfaces: tuple[Surface, ...] = field(repr=False)
    viewpoints: tuple[Viewpoint, ...] = field(repr=False)
    core_m: tuple[float, float, float, float] | None
    credit: Credit
    plan: WorldPlan = field(default_factory=WorldPlan, repr=False)


def read_objects(folder: Path) -> Iterator[Asset | AssetError]:
    """The objects of a folder's `index.json`; in place of one that cannot be used, why.

    Raises:
        AssetError: If the index is missing or damaged.
    """
    for facts in _json(folder / "index.json"):
        try:
            yield _object(folder, facts)
        except AssetError as error:
            yield AssetError(f"{folder / 'index.json'}: {error}")
        except (KeyError, TypeError, ValueError) as error:
            yield AssetError(f"{folder / 'index.json'}: {error!r} in {facts}")


def _object(folder: Path, facts: Mapping[str, Any]) -> Asset:
    path = folder / facts["file"]
    key, category = f"{folder.name}/{path.stem}", str(facts["category"])
    credit = _credit(facts, path.stem)
    width, height, depth = (float(side) for side in facts["size"])
    surfaces = tuple(_surfaces(path, facts.get("nodes", ())))
    if not surfaces:
        raise AssetError(f"{path} has no triangles")
    return Asset(
        key, path.stem.replace("_", " "), category, (width, depth, height), surfaces, credit
    )


def read_world(path: Path) -> World:
    """A world, `NAME.glb` with its JSON files.

    Raises:
        AssetError: If a file is missing or damaged.
    """
    facts = _json(path.with_suffix(".json"))
    views = _json(path.with_suffix(".cameras.json"))
    try:
        core = facts.get("core_xz")
        viewpoints = tuple(
            Viewpoint(
                upright(np.asarray(view["position"], np.float64)),
                upright(np.asarray(view["look_at"], np.float64)),
                float(view["eye_height"]),
            )
            for view in views["cameras"]
        )
        credit = _credit(facts, str(facts.get("title", path.stem)))
        nodes = facts["nodes"]
    except AssetError as error:
        raise AssetError(f"{path.with_suffix('.json')}: {error}") from error
    except (KeyError, TypeError, ValueError) as error:
        raise AssetError(f"{path.with_suffix('.json')}: {error!r}") from error
    surfaces, outdoors = tuple(_surfaces(path, nodes)), core is not None
    feet = [view.eye_m - (0, 0, view.height_m) for view in viewpoints]
    plan = plan_of(surfaces, np.array(feet).reshape(-1, 3), outdoors=outdoors)
    return World(path.stem, surfaces, viewpoints, _core(core), credit, plan)


def _core(core: Any) -> tuple[float, float, float, float] | None:  # noqa: ANN401 - from JSON
    """The built part in the axes of scenes, where y is -z of the source."""
    if core is None:
        return None
    (x0, z0), (x1, z1) = core
    return float(x0), -float(z1), float(x1), -float(z0)


def _surfaces(path: Path, nodes: Any) -> Iterator[Surface]:  # noqa: ANN401 - from JSON
    """The surfaces of a GLB file, a node each.

    Raises:
        AssetError: If the file is missing or damaged.
    """
    import trimesh

    try:
        about = {node["name"]: node for node in nodes}
        scene = trimesh.load_scene(path, process=False)
    except Exception as error:  # trimesh's readers raise nearly anything on odd files
        raise AssetError(f"{path} cannot be read: {error}") from error
    for name in scene.graph.nodes_geometry:
        facts = about.get(name, {})
        role = _ROLES.get(facts.get("role", "object"))
        if role is None:
            continue
        if facts.get("stairs") and role == "object":
            role = "stairs"
        matrix, geometry = scene.graph[name]
        mesh = scene.geometry[geometry]
        if not hasattr(mesh, "faces"):  # points and lines
            continue
        points = np.asarray(mesh.vertices, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        check_mesh(mesh, points, str(path))
        rgb = facts.get("rgb")
        yield from surfaces_of(
            mesh,
            points,
            rgb=None if rgb is None else (int(rgb[0]), int(rgb[1]), int(rgb[2])),
            has_alpha=bool(facts.get("alpha_mask")),
            role=role,
            name=str(name),
        )


def _credit(facts: Mapping[str, Any], title: str) -> Credit:
    source = facts["source"]
    return Credit(
        title,
        str(facts["author"]),
        free_licence(str(facts["licence"])),
        "; ".join(source) if isinstance(source, list) else str(source),
    )


def _json(path: Path) -> Any:  # noqa: ANN401
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise AssetError(f"{path} cannot be read: {error}") from error
