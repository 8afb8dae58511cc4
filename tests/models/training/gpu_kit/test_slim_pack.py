"""Packs made small: the training split, unchanged but for textures, the largest models last."""

import json
import lzma

import numpy as np
import pytest
import trimesh
from PIL import Image

from footprints_edge_models.asset_files.asset import AssetError
from footprints_edge_models.asset_files.pack import AssetPack, pack_assets
from footprints_edge_models.training.gpu_kit.slim_pack import write_slim_pack

CREDIT = {"licence": "CC0-1.0", "author": "Somebody", "source": "somewhere"}


def textured_ball(path, detail):
    mesh = trimesh.creation.icosphere(detail)
    picture = np.random.default_rng(detail).integers(0, 255, (400, 300, 3)).astype(np.uint8)
    mesh.visual = trimesh.visual.TextureVisuals(
        uv=mesh.vertices[:, :2],
        material=trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(picture)),
    )
    scene = trimesh.Scene()
    scene.add_geometry(mesh, node_name="body", geom_name="body")
    path.write_bytes(scene.export(file_type="glb"))


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    """A dozen balls, every other with many triangles; some of them belong to the test split."""
    root = tmp_path_factory.mktemp("assets")
    facts = []
    for number in range(12):
        textured_ball(root / f"ball{number}.glb", 4 if number % 2 else 1)
        facts.append({"file": f"ball{number}.glb", "category": "prop", "size": [2, 2, 2]})
        facts[-1] |= {"nodes": [{"name": "body"}], **CREDIT}
    (root / "index.json").write_text(json.dumps(facts))
    pack_assets([root], root / "assets.zip")
    return root / "assets.zip"


def slim(pack, folder, most_bytes):
    write_slim_pack(pack, folder / "slim.xz", most_bytes)
    assert (folder / "slim.xz").stat().st_size <= most_bytes
    (folder / "slim.zip").write_bytes(lzma.decompress((folder / "slim.xz").read_bytes()))
    return AssetPack(folder / "slim.zip")


def test_the_training_split_travels_and_only_textures_change(pack, tmp_path):
    whole, small = AssetPack(pack), slim(pack, tmp_path, 10**7)
    assert whole.of("model", "test")
    assert small.entries == whole.of("model", "train")
    for entry in small.entries:
        (before,), (after,) = whole.model(entry).surfaces, small.model(entry).surfaces
        assert np.array_equal(after.points, before.points)
        assert np.array_equal(after.triangles, before.triangles)
        assert np.array_equal(after.uv, before.uv)
        assert after.texture.shape == before.texture.shape == (256, 256, 3)


def test_the_largest_models_stay_behind_where_not_all_fit(pack, tmp_path):
    everything = slim(pack, tmp_path, 10**7)
    size = (tmp_path / "slim.xz").stat().st_size
    part = slim(pack, tmp_path, size * 7 // 10)
    assert 0 < len(part.entries) < len(everything.entries)
    left_out = {entry.key for entry in everything.entries} - {entry.key for entry in part.entries}
    fewest = min(entry.triangles for entry in everything.entries if entry.key in left_out)
    assert fewest >= max(entry.triangles for entry in part.entries)


def test_a_pack_that_cannot_fit_is_refused(pack, tmp_path):
    with pytest.raises(AssetError, match="without any models"):
        write_slim_pack(pack, tmp_path / "slim.xz", 100)
