import zipfile

import numpy as np
import pytest

from footprints_edge_models.asset_files.asset import AssetError
from footprints_edge_models.asset_files.sweet_home import SweetHomeCatalogue

# y up, front (the red face) along +z; 2 x 1 x 4 units along x, y, z
OBJ = """mtllib thing.mtl
v -1 0 -2
v 1 0 -2
v 1 1 -2
v -1 1 -2
v -1 0 2
v 1 0 2
v 1 1 2
v -1 1 2
usemtl red
f 5 6 7 8
usemtl wood
f 1 4 3 2
f 1 2 6 5
f 4 8 7 3
f 1 5 8 4
f 2 3 7 6
"""
MTL = "newmtl red\nKd 1 0 0\nnewmtl wood\nKd 0.5 0.25 0.125\n"


def catalogue(folder, entry="", licence="Public domain", extra=()):
    lines = [
        "name=Test",
        f"license={licence}",
        "id#1=Test#chest",
        "name#1=Chest",
        "category#1=Bedroom",
        "model#1=/models/thing.obj",
        "width#1=80",
        "depth#1=40",
        "height#1=50",
        "creator#1=Somebody",
        *entry.splitlines(),
    ]
    path = folder / "test.sh3f"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("PluginFurnitureCatalog.properties", "\n".join(lines))
        archive.writestr("models/thing.obj", OBJ)
        archive.writestr("models/Thing.MTL", MTL)  # Windows does not mind
        for name, text in extra:
            archive.writestr(name, text)
    return path


def read(path):
    with SweetHomeCatalogue(path) as found:
        (entry,) = found.entries
        return found.read(entry)


def corners(asset):
    points = np.concatenate([surface.points for surface in asset.surfaces])
    return points.min(axis=0), points.max(axis=0)


def test_a_model_has_the_size_of_the_catalogue_and_stands_on_the_ground(tmp_path):
    asset = read(catalogue(tmp_path))
    assert (asset.name, asset.category, asset.key) == ("Chest", "Bedroom", "test/chest")
    low, high = corners(asset)
    np.testing.assert_allclose(low, (-0.4, -0.2, 0), atol=1e-6)
    np.testing.assert_allclose(high, (0.4, 0.2, 0.5), atol=1e-6)


def test_its_front_looks_along_minus_y(tmp_path):
    asset = read(catalogue(tmp_path))
    (front,) = [surface for surface in asset.surfaces if surface.rgb == (255, 0, 0)]
    used = front.points[front.triangles]
    np.testing.assert_allclose(used[..., 1], -0.2, atol=1e-6)


def test_colours_are_those_of_the_material_file_whatever_its_case(tmp_path):
    colours = {surface.rgb for surface in read(catalogue(tmp_path)).surfaces}
    assert (255, 0, 0) in colours
    (wood,) = colours - {(255, 0, 0)}
    np.testing.assert_allclose(wood, (128, 64, 32), atol=1)


def test_a_model_is_turned_before_it_is_scaled(tmp_path):
    # a quarter turn about y: what looked along +z looks along +x
    asset = read(catalogue(tmp_path, "modelRotation#1=0 0 1 0 1 0 -1 0 0"))
    low, high = corners(asset)
    np.testing.assert_allclose(high - low, (0.8, 0.4, 0.5), atol=1e-6)
    (front,) = [surface for surface in asset.surfaces if surface.rgb == (255, 0, 0)]
    np.testing.assert_allclose(front.points[front.triangles][..., 0], 0.4, atol=1e-6)


def test_an_elevated_model_hangs_above_the_ground(tmp_path):
    low, high = corners(read(catalogue(tmp_path, "elevation#1=120")))
    np.testing.assert_allclose((low[2], high[2]), (1.2, 1.7), atol=1e-6)


@pytest.mark.parametrize(
    ("licence", "text", "expected"),
    [
        ("Public domain", None, "CC0-1.0"),
        ("Creative Commons Attribution 3.0 license", None, "CC-BY-3.0"),
        ("", "under the Creative Commons Attribution 3.0\nUnported license", "CC-BY-3.0"),
        ("", "Works in the public domain ... Creative Commons Attribution 3.0", "CC-BY-3.0"),
    ],
)
def test_the_credit_names_author_and_licence(tmp_path, licence, text, expected):
    extra = [("LICENSE.TXT", text)] if text else []
    credit = read(catalogue(tmp_path, licence=licence, extra=extra)).credit
    assert (credit.author, credit.licence) == ("Somebody", expected)


@pytest.mark.parametrize(
    "licence",
    [
        *("", "All rights reserved", "Creative Commons Attribution 3.0 NonCommercial"),
        "Creative Commons Attribution-ShareAlike 3.0; elements in the public domain are free",
    ],
)
def test_a_catalogue_that_may_not_be_shipped_is_refused(tmp_path, licence):
    with pytest.raises(AssetError, match="none of CC0 and CC BY"):
        SweetHomeCatalogue(catalogue(tmp_path, licence=licence))


def test_a_missing_model_is_named(tmp_path):
    path = catalogue(tmp_path, "model#1=/models/gone.obj")
    with pytest.raises(AssetError, match=r"test/chest.*gone\.obj"):
        read(path)


def test_another_zip_is_refused(tmp_path):
    path = tmp_path / "other.sh3f"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("hello", "")
    with pytest.raises(AssetError, match="not a Sweet Home 3D catalogue"):
        SweetHomeCatalogue(path)
    path.write_bytes(b"no zip")
    with pytest.raises(AssetError, match="not a Sweet Home 3D catalogue"):
        SweetHomeCatalogue(path)


def test_a_damaged_line_costs_itself_alone(tmp_path):
    damaged = "model#2=/models/thing.obj\nwidth#2=wide\ndepth#2=1\nheight#2=1"
    with SweetHomeCatalogue(catalogue(tmp_path, damaged)) as found:
        assert [entry.name for entry in found.entries] == ["Chest"]
        assert [str(error).split(":")[0] for error in found.damaged] == ["test, entry 2"]


def test_escaped_letters_are_read(tmp_path):
    asset = read(catalogue(tmp_path, "creator#1=Zo\\u00eb"))
    assert asset.credit.author == "Zoë"
