"""Folders of synthetic scenes: ground truth survives writing and reading, any number of processes
writes the same bytes, splits share nothing, training draws the right samples."""

import json

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from footprints_edge.geometry.camera import rays
from footprints_edge_models.cli import app
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.readers.synthetic_scenes import (
    MOST_BEHIND_WALL_M,
    read_synthetic_scenes,
)
from footprints_edge_models.sample import FOOTPRINT, NO, UNSEEN, YES
from footprints_edge_models.scenes.assets.textures.library import (
    TextureKey,
    TextureLibrary,
    photo_split,
)
from footprints_edge_models.scenes.assets.textures.patterns import PATTERNS
from footprints_edge_models.scenes.generate import generate_scene, generate_views
from footprints_edge_models.scenes.ground_truth.pixels import (
    BEHIND_WALL,
    GROUND_ANYWHERE,
    VISIBLE_GROUND,
)
from footprints_edge_models.scenes.ground_truth.pixels import FOOTPRINT as FOOTPRINT_BIT
from footprints_edge_models.scenes.make import make_scenes
from footprints_edge_models.scenes.rendering.cameras import choose_camera
from footprints_edge_models.scenes.rendering.raycast import Triangles
from footprints_edge_models.scenes.storage.files import (
    SceneFilesError,
    SceneSettings,
    read_scene,
    read_settings,
    scene_names,
)

SIZE = (96, 160)


def fill(folder, count=4, *, jobs=1, split="train", seed=3, textures=(), views=1, first=0):
    reported = []
    settings = SceneSettings(split, seed, SIZE, views=views)
    make_scenes(folder, settings, list(textures), count, jobs, reported.append, first)
    return reported


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "synthetic_scenes"
    fill(folder, 8)
    return folder


@pytest.fixture(scope="module")
def apart(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "made_test"
    fill(folder, 3, split="test")
    return folder


@pytest.mark.parametrize("number", range(4))
def test_what_is_read_is_what_was_true(folder, library, number):
    made, read = generate_scene(library, 3, number, SIZE), read_scene(folder, f"{number:06d}")
    assert np.array_equal(read.ground_truth.bits, made.ground_truth.bits)
    assert read.intrinsics == made.camera.intrinsics
    assert np.array_equal(
        read.ground_truth.ground_depth_m > 0, made.ground_truth.ground_depth_m > 0
    )
    # beyond a few degrees of the horizon, half a millimetre of height is a lot of depth
    for name, tolerance in (("ground_depth_m", 0.002), ("visible_depth_m", 0.005)):
        mine, theirs = getattr(read.ground_truth, name), getattr(made.ground_truth, name)
        known = (theirs > 0.25) & (theirs < 80)
        assert np.allclose(mine[known], theirs[known], rtol=tolerance)
    difference = np.abs(read.image.astype(float) - made.image).mean()
    assert difference < 12


def test_any_number_of_processes_writes_the_same_bytes(folder, tmp_path):
    fill(tmp_path / "two", 4, jobs=2)
    names = scene_names(tmp_path / "two")
    assert names == scene_names(folder)[:4]
    for name in names:
        for part in (f"images/{name}.jpg", f"truth/{name}.npz"):
            assert (folder / part).read_bytes() == (tmp_path / "two" / part).read_bytes()


def test_a_folder_is_gone_on_with_and_kept(folder, tmp_path):
    fill(tmp_path, 3)
    before = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*.npz")}
    (tmp_path / "truth" / "000001.npz").unlink()
    reported = fill(tmp_path, 5)
    assert sorted(outcome.state for outcome in reported) == ["done"] * 3 + ["kept"] * 2
    assert len(scene_names(tmp_path)) == 5
    for path, stamp in before.items():
        if path.stem != "000001":
            assert path.stat().st_mtime_ns == stamp
    again = (tmp_path / "truth" / "000001.npz").read_bytes()
    assert again == (folder / "truth" / "000001.npz").read_bytes()
    assert not list(tmp_path.rglob("*.part*"))


def test_other_settings_are_refused(folder):
    with pytest.raises(SceneFilesError, match="another folder"):
        fill(folder, 1, seed=4)


def test_a_damaged_scene_is_named(tmp_path):
    fill(tmp_path, 1)
    path = tmp_path / "truth" / "000000.npz"
    path.write_bytes(path.read_bytes()[:500])
    with pytest.raises(SceneFilesError, match=r"000000\.npz"):
        read_scene(tmp_path, "000000")


def test_samples_say_what_is_known(folder):
    samples = read_synthetic_scenes(folder)
    assert len(samples) == 8
    for name, sample in zip(samples.names, samples, strict=True):
        truth = read_scene(folder, name).ground_truth
        assert ((sample.visible_ground == YES) == (truth.bits & VISIBLE_GROUND > 0)).all()
        assert set(np.unique(sample.visible_ground)) <= {NO, YES}
        gap_m = truth.ground_depth_m - truth.visible_depth_m
        far = (truth.bits & BEHIND_WALL > 0) & (gap_m > MOST_BEHIND_WALL_M)
        assert ((sample.ground == UNSEEN) == far).all()
        known = truth.bits & GROUND_ANYWHERE > 0
        assert ((sample.ground == FOOTPRINT) == ((truth.bits & FOOTPRINT_BIT > 0) & ~far)).all()
        assert ((sample.ground == YES) == (known & ~far)).all()
        assert ((sample.ground_depth_m > 0) == (sample.ground == YES)).all()
        assert not ((sample.visible_ground == YES) & (sample.ground != YES)).any()
    half = samples[2:5]
    assert half.names == samples.names[2:5]
    assert np.array_equal(half[0].image, samples[2].image)


def test_training_finds_them_and_reads_them_when_drawn(folder):
    dataset = load_datasets(folder.parent)["synthetic_scenes"]
    assert len(dataset.train) == 8
    assert dataset.train[0].image.shape[2] == 3


def test_test_scenes_are_not_trained_on(apart):
    with pytest.raises(SceneFilesError, match="test split"):
        read_synthetic_scenes(apart)
    (apart.parent / "synthetic_scenes").symlink_to(apart)
    with pytest.raises(DatasetError, match="test split"):
        load_datasets(apart.parent)


def test_splits_share_no_scene(folder, apart):
    train, test = read_scene(folder, "000000"), read_scene(apart, "000000")
    assert train.image.shape != test.image.shape or not np.array_equal(train.image, test.image)


def test_splits_share_no_texture():
    train, test = TextureLibrary("train"), TextureLibrary("test")
    for kind in set(PATTERNS) - {"blank"}:  # one grey, to be tinted
        drawn = {train.draw(TextureKey(kind, n)).tobytes() for n in range(4)}
        assert not drawn & {test.draw(TextureKey(kind, n)).tobytes() for n in range(4)}


def test_a_photo_gives_textures_to_one_split(tmp_path):
    rng = np.random.default_rng(0)
    for number in range(40):
        picture = rng.integers(0, 255, (40, 50, 3), dtype=np.uint8)
        cv2.imwrite(str(tmp_path / f"{number}.png"), picture)
    train, test = (TextureLibrary.over(split, [tmp_path]).photos for split in ("train", "test"))
    assert len(train) + len(test) == 40
    assert train
    assert test
    assert not set(train) & set(test)
    moved = test[0].rename(tmp_path / "moved.png")  # its bytes decide, not its name
    assert photo_split(moved) == "test"


def test_photos_that_give_textures_are_credited(tmp_path):
    photos, own = tmp_path / "camvid" / "train" / "images", tmp_path / "holiday"
    for folder in (photos, own):
        folder.mkdir(parents=True)
    fill(tmp_path / "scenes", 0, textures=[photos, own])
    credits = json.loads((tmp_path / "scenes" / "credits.json").read_text())
    found = {each["title"]: each["licence"] for each in credits}
    assert found == {"CamVid": "CC-BY-NC-4.0", "holiday": "not stated"}


def test_textures_tile():
    library = TextureLibrary("train")
    for kind in ("concrete", "carpet", "fabric", "plaster", "grass"):
        texture = library.draw(TextureKey(kind, 1)).astype(float)
        seam = np.abs(texture[:, 0] - texture[:, -1]).mean()
        inside = np.abs(np.diff(texture, axis=1)).mean()
        assert seam < 3 * inside + 2, kind


def test_boxes_and_voxels_are_what_the_bench_reads(apart):
    from footprints_edge_bench.geometry.boxes import read_boxes
    from footprints_edge_bench.geometry.voxels import read_voxels

    boxes = read_boxes(apart / "boxes.json")
    assert set(boxes) == {f"{apart.name}/{name}" for name in scene_names(apart)}
    assert any(boxes.values())
    for name in scene_names(apart):
        made = read_scene(apart, name)
        size = made.image.shape[:2]
        grid = read_voxels(apart / "voxels" / f"{name}.npz")
        depth_m, _ = grid.floor(made.intrinsics, size)
        visible_m = made.ground_truth.visible_depth_m
        # SSCNet's volume ends 2.4 m to the side of the camera and 4.8 m ahead
        right = np.abs(rays(made.intrinsics, size)[..., 0])
        near = (made.ground_truth.bits & VISIBLE_GROUND > 0) & (
            visible_m * np.maximum(right, 0.6) < 2
        )
        both = near & np.isfinite(depth_m)
        assert both.sum() >= 0.9 * near.sum()
        assert not np.isfinite(depth_m[visible_m > 6]).any()
        assert np.abs(depth_m[both] / visible_m[both] - 1).mean() < 0.08


def test_the_command_makes_goes_on_and_shows(tmp_path):
    sheet = tmp_path / "sheet.png"
    arguments = ["scenes", str(tmp_path / "out"), "--count", "2", "--size", "64x96", "-j", "1"]
    first = CliRunner().invoke(app, arguments)
    assert first.exit_code == 0, first.output
    said = json.loads(first.stdout.splitlines()[-1])
    assert (said["made"], said["kept"]) == (2, 0)
    assert said["pictures_per_second_and_process"] > 0
    second = CliRunner().invoke(app, [*arguments, "--preview", str(sheet)])
    assert json.loads(second.stdout.splitlines()[-1])["kept"] == 2
    assert cv2.imread(str(sheet)).shape[1] > 500
    assert read_settings(tmp_path / "out").size == (64, 96)


def test_a_folder_without_scenes_is_explained(tmp_path):
    with pytest.raises(SceneFilesError, match="fp-train scenes"):
        read_synthetic_scenes(tmp_path)


def test_a_scene_that_fails_costs_only_itself(folder, tmp_path, monkeypatch):
    def failing(library, seed, number, *rest):
        if number == 1:
            raise ZeroDivisionError("no camera")
        return generate_views(library, seed, number, *rest)

    monkeypatch.setattr("footprints_edge_models.scenes.make.generate_views", failing)
    out = tmp_path / "out"
    arguments = ["scenes", str(out), "--count", "3", "--seed", "3", "--size", "96x160", "-j", "1"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 1, result.output
    assert "scene 1 failed: ZeroDivisionError: no camera" in result.stderr
    said = json.loads(result.stdout.splitlines()[-1])
    assert (said["made"], said["kept"], said["failed"]) == (2, 0, 1)
    assert scene_names(out) == ["000000", "000002"]
    monkeypatch.undo()
    said = json.loads(CliRunner().invoke(app, arguments).stdout.splitlines()[-1])
    assert (said["made"], said["kept"], said["failed"]) == (1, 2, 0)
    for name in scene_names(out):
        assert (out / f"truth/{name}.npz").read_bytes() == (
            folder / f"truth/{name}.npz"
        ).read_bytes()


@pytest.fixture(scope="module")
def views(tmp_path_factory):
    """Three scenes, three pictures of each."""
    folder = tmp_path_factory.mktemp("views") / "synthetic_scenes"
    fill(folder, 9, views=3)
    return folder


def test_the_views_of_a_scene_show_one_place_from_different_standpoints(views, folder):
    assert scene_names(views) == [f"{number:06d}" for number in range(9)]
    for scene in range(3):
        pictures = [read_scene(views, f"{3 * scene + view:06d}") for view in range(3)]
        assert len({picture.kind for picture in pictures}) == 1
        for one, other in ((0, 1), (0, 2), (1, 2)):
            first, second = pictures[one], pictures[other]
            assert not np.allclose(first.up, second.up)
            if first.image.shape == second.image.shape:
                assert np.abs(first.image.astype(float) - second.image).mean() > 5
        # the first view is the picture that a set of one view a scene has
        alone = read_scene(folder, f"{scene:06d}")
        assert np.array_equal(alone.ground_truth.bits, pictures[0].ground_truth.bits)


def test_what_one_camera_saw_the_next_does_not_see_again(library):
    made = list(generate_views(library, 3, 0, SIZE, 4))
    assert [view.view for view in made] == list(range(4))
    assert all(view.geometry is made[0].geometry for view in made)
    solids = Triangles(made[0].geometry.points, made[0].geometry.triangles)
    for later in made[1:]:
        rays_ = later.camera.rays((24, 40))
        hits = solids.first_hits(*rays_)
        met = hits.triangle >= 0
        points = rays_[0][met] + rays_[1][met] * hits.distance[met, None]
        for before in made[: later.view]:
            local = (points - before.camera.position_m) @ before.camera.rotation
            k, (height, width) = before.camera.intrinsics, before.camera.size
            ahead = np.where(local[:, 2] > 0.01, local[:, 2], np.inf)
            at = local[:, 0] / ahead * k.fx + k.cx, local[:, 1] / ahead * k.fy + k.cy
            inside = (np.isfinite(ahead)) & (abs(at[0] / width - 0.5) < 0.5)
            inside &= abs(at[1] / height - 0.5) < 0.5
            nearness = np.linalg.norm(points - before.camera.position_m, axis=1)
            nearness /= np.linalg.norm(points - later.camera.position_m, axis=1)
            assert (inside & (abs(np.log(nearness)) < np.log(1.6))).mean() < 0.5


def test_a_part_made_scene_is_completed_to_the_same_bytes(views, tmp_path):
    fill(tmp_path, 4, views=3)  # all of one scene, and one picture of the next
    assert scene_names(tmp_path) == [f"{number:06d}" for number in range(4)]
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "images").iterdir()}
    (tmp_path / "images" / "000001.jpg").unlink()
    results = [outcome.result for outcome in fill(tmp_path, 9, views=3)]
    assert sorted((len(result.made), result.kept) for result in results) == [(1, 2), (2, 1), (3, 0)]
    for path, stamp in before.items():
        if path.stem != "000001":
            assert path.stat().st_mtime_ns == stamp
    for name in scene_names(views):
        for part in (f"images/{name}.jpg", f"truth/{name}.npz"):
            assert (views / part).read_bytes() == (tmp_path / part).read_bytes()
    assert {outcome.state for outcome in fill(tmp_path, 9, views=3)} == {"kept"}


def test_parts_made_on_several_machines_are_the_whole(views, tmp_path):
    parts = {"one": range(4), "other": range(4, 9)}  # they share a scene
    for machine, numbers in parts.items():
        fill(tmp_path / machine, len(numbers), views=3, first=numbers.start)
        assert scene_names(tmp_path / machine) == [f"{number:06d}" for number in numbers]
        for name in scene_names(tmp_path / machine):
            for part in (f"images/{name}.jpg", f"truth/{name}.npz"):
                assert (views / part).read_bytes() == (tmp_path / machine / part).read_bytes()


def test_another_number_of_views_is_refused(views):
    with pytest.raises(SceneFilesError, match="views=3"):
        fill(views, 9, views=4)


def test_a_scene_with_fewer_views_is_finished_without_the_others(tmp_path, monkeypatch):
    def shy(*arguments):
        earlier = arguments[-1]
        return None if len(earlier) == 2 else choose_camera(*arguments)

    monkeypatch.setattr("footprints_edge_models.scenes.generate.choose_camera", shy)
    (outcome,) = fill(tmp_path, 4, views=4)
    assert (len(outcome.result.made), outcome.result.kept) == (2, 0)
    assert scene_names(tmp_path) == ["000000", "000001"]
    (outcome,) = fill(tmp_path, 4, views=4)
    assert (outcome.state, outcome.result.kept) == ("kept", 2)


def test_the_command_makes_several_views(tmp_path):
    arguments = ["scenes", str(tmp_path / "out"), "--count", "5", "--size", "64x96", "-j", "1"]
    made = CliRunner().invoke(app, [*arguments, "--views", "2"])
    assert made.exit_code == 0, made.output
    said = json.loads(made.stdout.splitlines()[-1])
    assert (said["made"], said["views"]) == (5, 2)
    assert read_settings(tmp_path / "out").views == 2
    other = CliRunner().invoke(app, arguments)
    assert other.exit_code == 2 and "another folder" in other.output
