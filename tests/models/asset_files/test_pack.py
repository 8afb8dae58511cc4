import io
import json
import shutil
import zipfile

import numpy as np
import pytest
import trimesh
from PIL import Image

from footprints_edge_models.asset_files.asset import AssetError
from footprints_edge_models.asset_files.glb import World
from footprints_edge_models.asset_files.pack import AssetPack, pack_assets


def glb(path, size, colour=(255, 0, 0)):
    mesh = trimesh.creation.box(size)
    mesh.apply_translation((0, size[1] / 2, 0))
    mesh.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(baseColorFactor=[*colour, 255])
    )
    scene = trimesh.Scene()
    scene.add_geometry(mesh, node_name="body", geom_name="body")
    path.write_bytes(scene.export(file_type="glb"))


@pytest.fixture
def folder(tmp_path):
    """One object, one world, a texture and a panorama, as their sources lay them out."""
    root = tmp_path / "assets"
    for name in ("objects/street", "worlds", "textures", "panoramas"):
        (root / name).mkdir(parents=True)
    credit = {"licence": "CC0-1.0", "author": "Somebody", "source": "somewhere"}
    facts = {"file": "car.glb", "category": "car", "size": [1.8, 1.5, 4.4], **credit}
    objects = [
        facts | {"nodes": [{"name": "body", "rgb": [10, 20, 30]}]},
        facts | {"file": "gone.glb", "nodes": []},
    ]
    (root / "objects/street/index.json").write_text(json.dumps(objects))
    glb(root / "objects/street/car.glb", (1.8, 1.5, 4.4))
    glb(root / "worlds/hall.glb", (6, 3, 8))
    about = {"title": "A hall", "nodes": [{"name": "body", "role": "wall"}], **credit}
    (root / "worlds/hall.json").write_text(json.dumps(about))
    camera = {"position": [1, 1.5, -2], "look_at": [0, 1, 0], "eye_height": 1.5}
    (root / "worlds/hall.cameras.json").write_text(json.dumps({"cameras": [camera]}))
    for name, more in (
        ("textures", {"cls": "woodfloor", "use": "floor"}),
        ("panoramas", {"projection": "equirectangular", "shows": "a room", "setting": "indoor"}),
    ):
        Image.new("RGB", (64, 32), (200, 100, 50)).save(root / name / "one.jpg")
        (root / name / "index.json").write_text(json.dumps([{"file": "one.jpg", **more, **credit}]))
    return root


def test_everything_comes_back_out_of_a_pack(folder, tmp_path):
    report = pack_assets([folder], tmp_path / "assets.zip")
    assert report.counts == {"model": 1, "world": 1, "texture": 1, "panorama": 1}
    assert len(report.skipped) == 1 and "gone.glb" in report.skipped[0]
    pack = AssetPack(tmp_path / "assets.zip")
    kinds = {entry.kind: entry for entry in pack.entries}
    assert {entry.credit.author for entry in pack.entries} == {"Somebody"}
    car = pack.model(kinds["model"])
    (body,) = car.surfaces
    assert body.rgb == (10, 20, 30)  # the index knows better than the file
    np.testing.assert_allclose(np.ptp(body.points, axis=0), (1.8, 4.4, 1.5), atol=1e-3)
    assert body.points[:, 2].min() == pytest.approx(0, abs=1e-4)
    (outline,) = car.outlines
    np.testing.assert_allclose(np.ptp(outline, axis=0), (1.8, 4.4), atol=1e-3)
    hall = pack.world(kinds["world"])
    assert [surface.role for surface in hall.surfaces] == ["wall"]
    (view,) = hall.viewpoints
    np.testing.assert_allclose(view.eye_m, (1, 2, 1.5))  # z of the source is -y here
    assert view.height_m == 1.5
    for kind in ("texture", "panorama"):
        pixels = pack.picture(kinds[kind])
        assert pixels.shape == (32, 64, 3)
        np.testing.assert_allclose(pixels.mean(axis=(0, 1)), (200, 100, 50), atol=3)


def test_packing_again_gives_the_same_bytes(folder, tmp_path):
    for name in ("a.zip", "b.zip"):
        pack_assets([folder], tmp_path / name)
    indices = [AssetPack(tmp_path / name).entries for name in ("a.zip", "b.zip")]
    assert indices[0] == indices[1]


def test_no_asset_belongs_to_both_splits(folder, tmp_path):
    pack_assets([folder], tmp_path / "assets.zip")
    pack = AssetPack(tmp_path / "assets.zip")
    for kind in ("model", "world", "texture", "panorama"):
        train, test = (pack.of(kind, split) for split in ("train", "test"))
        assert len(train) + len(test) == 1


def test_nothing_found_and_no_folder_are_errors(tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(AssetError, match="no asset found"):
        pack_assets([tmp_path / "empty"], tmp_path / "assets.zip")
    assert not (tmp_path / "assets.zip").exists()
    with pytest.raises(AssetError, match="no such folder"):
        pack_assets([tmp_path / "gone"], tmp_path / "assets.zip")


def test_another_file_is_not_a_pack(tmp_path):
    (tmp_path / "x.zip").write_bytes(b"no zip")
    with pytest.raises(AssetError, match="not a pack"):
        AssetPack(tmp_path / "x.zip")


def test_an_odd_asset_costs_itself_alone(folder, tmp_path):
    index = folder / "objects/street/index.json"
    objects = json.loads(index.read_text())
    points = trimesh.Scene(trimesh.PointCloud([[0, 0, 0], [1, 1, 1]]))
    (folder / "objects/street/points.glb").write_bytes(points.export(file_type="glb"))
    nameless = objects[0] | {"nodes": [{"rgb": [1, 2, 3]}]}
    odd = [nameless, objects[0] | {"file": "points.glb"}, {"category": "car"}]
    index.write_text(json.dumps([*odd, objects[0]]))
    report = pack_assets([folder], tmp_path / "assets.zip")
    assert report.counts["model"] == 1
    assert len(report.skipped) == 3
    (model,) = [e for e in AssetPack(tmp_path / "assets.zip").entries if e.kind == "model"]
    assert model.key == "street/car"


@pytest.mark.parametrize(
    ("good", "bad", "says"),
    [
        (np.uint32(7).tobytes(), np.uint32(10**9).tobytes(), "of vertex 1000000000"),
        (np.float32(2.2).tobytes(), np.float32(np.nan).tobytes(), "finite place"),
    ],
    ids=["vertex", "place"],
)
def test_a_mesh_of_impossible_numbers_costs_itself_alone(folder, tmp_path, good, bad, says):
    path = folder / "objects/street/car.glb"
    data = path.read_bytes()
    assert good in data
    path.write_bytes(data.replace(good, bad))
    report = pack_assets([folder], tmp_path / "assets.zip")
    assert "model" not in report.counts and report.counts["world"] == 1
    assert any("car.glb" in reason and says in reason for reason in report.skipped)


@pytest.mark.parametrize(
    "path", ["objects/street/index.json", "worlds/hall.json", "textures/index.json"]
)
def test_what_not_everybody_may_use_stays_out(folder, tmp_path, path):
    index = folder / path
    index.write_text(index.read_text().replace("CC0-1.0", "CC-BY-NC-4.0"))
    report = pack_assets([folder], tmp_path / "assets.zip")
    assert sum(report.counts.values()) == 3
    assert any("'CC-BY-NC-4.0' is none" in reason and path in reason for reason in report.skipped)


def test_of_two_assets_of_one_name_the_first_is_kept(folder, tmp_path):
    twin = tmp_path / "twin/objects/street"
    twin.parent.mkdir(parents=True)
    shutil.copytree(folder / "objects/street", twin)
    report = pack_assets([folder, tmp_path / "twin"], tmp_path / "assets.zip")
    assert report.counts["model"] == 1
    assert any("another of this name" in reason for reason in report.skipped)


def test_an_index_of_something_else_is_named(folder, tmp_path):
    (folder / "other").mkdir()
    (folder / "other/index.json").write_text('[{"hello": 1}]')
    report = pack_assets([folder], tmp_path / "assets.zip")
    assert any("lists neither objects" in reason for reason in report.skipped)


def test_a_vehicle_is_packed_with_its_length_along_y(folder, tmp_path):
    index = folder / "objects/street/index.json"
    facts = json.loads(index.read_text())[0]
    turned = facts | {"file": "taxi.glb", "size": [4.4, 1.5, 1.8]}
    bench = facts | {"file": "bench.glb", "category": "prop", "size": [4.4, 1.5, 1.8]}
    for name in ("taxi", "bench"):
        glb(folder / f"objects/street/{name}.glb", (4.4, 1.5, 1.8))
    index.write_text(json.dumps([facts, turned, bench]))
    pack_assets([folder], tmp_path / "assets.zip")
    pack = AssetPack(tmp_path / "assets.zip")
    models = {e.key: e for e in pack.entries if e.kind == "model"}
    for key, size_m in (("car", (1.8, 4.4)), ("taxi", (1.8, 4.4)), ("bench", (4.4, 1.8))):
        entry = models[f"street/{key}"]
        assert entry.size_m[:2] == size_m
        asset = pack.model(entry)
        (body,) = asset.surfaces
        np.testing.assert_allclose(np.ptp(body.points, axis=0)[:2], size_m, atol=1e-3)
        taken = np.concatenate(asset.outlines)
        np.testing.assert_allclose(np.ptp(taken, axis=0), size_m, atol=0.05)


def test_a_texture_that_surfaces_share_is_packed_once(folder, tmp_path):
    rng = np.random.default_rng(0)
    noise = Image.fromarray(rng.integers(0, 256, (128, 128, 3), np.uint8).repeat(2, axis=0))
    scene = trimesh.Scene()
    for number in range(5):
        mesh = trimesh.creation.box((1, 1, 1))
        mesh.apply_translation((2 * number, 0.5, 0))
        uv = mesh.vertices[:, :2] + number
        material = trimesh.visual.material.PBRMaterial(baseColorTexture=noise)
        mesh.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
        scene.add_geometry(mesh, node_name=f"box{number}", geom_name=f"box{number}")
    (folder / "worlds/hall.glb").write_bytes(scene.export(file_type="glb"))
    pack_assets([folder], tmp_path / "assets.zip")
    pack = AssetPack(tmp_path / "assets.zip")
    (entry,) = [e for e in pack.entries if e.kind == "world"]
    world = pack.world(entry)
    assert isinstance(world, World) and len(world.surfaces) == 5
    assert len({id(surface.texture) for surface in world.surfaces}) == 1
    assert world.surfaces[0].texture.shape == (256, 128, 3)
    middles = [surface.points[:, 0].mean() for surface in world.surfaces]
    np.testing.assert_allclose(sorted(middles), (0, 2, 4, 6, 8), atol=1e-3)
    for x, surface in zip(middles, world.surfaces, strict=True):  # each has its own part of the uv
        assert surface.uv.mean() == pytest.approx((x + 0.5) / 2 + x / 2, abs=1e-3)
    with zipfile.ZipFile(io.BytesIO((tmp_path / "assets.zip").read_bytes())) as archive:
        (name,) = [name for name in archive.namelist() if name.startswith("worlds/")]
        with np.load(io.BytesIO(archive.read(name))) as arrays:
            assert [key for key in arrays if key.startswith("texture") and key[-1].isdigit()] == [
                "texture0"
            ]
    small = tmp_path / "small.zip"
    pack_assets([folder], small, texture_px=32)
    assert AssetPack(small).world(entry).surfaces[0].texture.shape == (32, 32, 3)
    assert small.stat().st_size < 0.3 * (tmp_path / "assets.zip").stat().st_size


def test_a_pack_of_an_older_format_is_refused(folder, tmp_path):
    pack_assets([folder], tmp_path / "assets.zip")
    with zipfile.ZipFile(tmp_path / "old.zip", "w") as archive:
        archive.writestr("index.json", json.dumps({"format": 1, "entries": []}))
    with pytest.raises(AssetError, match=r"format 1.*pack the assets again"):
        AssetPack(tmp_path / "old.zip")


def test_a_fine_model_is_simplified_and_one_that_cannot_be_is_left_out(
    folder, tmp_path, monkeypatch
):
    pytest.importorskip("fast_simplification")
    index = folder / "objects/street/index.json"
    facts = json.loads(index.read_text())[0] | {"category": "prop", "size": [2, 2, 2]}
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.icosphere(4), node_name="body", geom_name="body")
    (folder / "objects/street/ball.glb").write_bytes(scene.export(file_type="glb"))
    index.write_text(json.dumps([facts | {"file": "ball.glb"}]))
    pack_assets([folder], tmp_path / "assets.zip", most_triangles=300)
    (ball,) = [e for e in AssetPack(tmp_path / "assets.zip").entries if e.kind == "model"]
    assert ball.key == "street/ball" and 250 <= ball.triangles <= 310
    monkeypatch.setattr(
        "footprints_edge_models.asset_files.pack.simplified", lambda surfaces, _: tuple(surfaces)
    )
    report = pack_assets([folder], tmp_path / "assets.zip", most_triangles=300)
    assert "model" not in report.counts
    assert any("street/ball: 5120 triangles" in reason for reason in report.skipped)


def spoiled(pack, name, change):
    """A pack one of whose files is another, its checksum right."""
    with zipfile.ZipFile(pack) as archive:
        files = {each: archive.read(each) for each in archive.namelist()}
    files[name] = change(files[name])
    with zipfile.ZipFile(pack, "w") as archive:
        for each, data in files.items():
            archive.writestr(each, data)
    return pack


def with_arrays(**changes):
    def changed(data):
        with np.load(io.BytesIO(data)) as there:
            arrays = {name: there[name] for name in there.files}
        arrays |= {name: change(arrays[name]) for name, change in changes.items()}
        buffer = io.BytesIO()
        np.savez(buffer, **arrays)
        return buffer.getvalue()

    return changed


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("models/street/car.npz", lambda _: b"no arrays"),
        ("models/street/car.npz", with_arrays(triangles=lambda a: a + 9000)),
        ("models/street/car.npz", with_arrays(point_counts=lambda a: a + 1)),
        ("models/street/car.npz", with_arrays(boxes=lambda a: a * np.nan)),
        ("models/street/car.npz", with_arrays(uv=lambda a: a, textures=lambda a: a + 3)),
        ("models/street/car.npz", with_arrays(outline_lengths=lambda a: a - 1)),
        ("worlds/hall.npz", with_arrays(eyes=lambda a: a[:, :2])),
        ("worlds/hall.npz", with_arrays(thing_of=lambda a: np.repeat(a, 2))),
        ("textures/one.jpg", lambda data: data[:200]),
        ("panoramas/one.jpg", lambda _: b"no picture"),
    ],
)
def test_what_is_damaged_in_a_pack_is_named(folder, tmp_path, name, change):
    pack_assets([folder], tmp_path / "assets.zip")
    pack = AssetPack(spoiled(tmp_path / "assets.zip", name, change))
    (entry,) = [each for each in pack.entries if name.startswith(f"{each.kind}s/")]
    read = pack.picture if name.endswith(".jpg") else getattr(pack, entry.kind)
    with pytest.raises(AssetError, match=name):
        read(entry)


@pytest.mark.parametrize(
    "change",
    [
        lambda _: b"[]",
        lambda _: b"{}",
        lambda _: b"[" * 99999,
        lambda data: data.replace(b'"size_m": [', b'"size_m": [NaN,'),
        lambda data: data.replace(b'"kind": "model"', b'"kind": "toy"'),
        lambda data: data.replace(b'"author": "Somebody"', b'"author": {}'),
    ],
)
def test_an_index_that_is_none_is_refused(folder, tmp_path, change):
    pack_assets([folder], tmp_path / "assets.zip")
    with pytest.raises(AssetError, match=r"assets\.zip"):
        AssetPack(spoiled(tmp_path / "assets.zip", "index.json", change))


def test_a_pack_that_unpacks_to_more_than_its_size_is_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("index.json", b" " * 10**6)
    with pytest.raises(AssetError, match="unpacks to 1000000 bytes"):
        AssetPack(tmp_path / "bomb.zip")
