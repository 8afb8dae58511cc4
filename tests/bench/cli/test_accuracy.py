"""`fp-bench accuracy` from end to end, on tiny synthetic data."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from functools import partial

import numpy as np
import pytest
from PIL import Image

from footprints_edge_bench.accuracy.results import Results

SIZE = (32, 64)

REPORTS = ("accuracy.md", "accuracy.json", "per-image.csv", "worst.png")


@pytest.fixture
def run(fp_bench):
    """`fp-bench accuracy` in this process."""
    return partial(fp_bench, "accuracy")


def picture(visible, ground):
    """A photo that the model of these tests takes for this."""
    image = np.zeros((*np.shape(visible), 3), np.uint8)
    image[..., 0], image[..., 1] = np.where(ground, 250, 5), np.where(visible, 250, 5)
    return Image.fromarray(image)


def write_photo(folder, name, found, ids):
    """A photo that the model calls ground where `found`, and its labels."""
    for part in ("images", "labels"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    picture(found, found).save(folder / "images" / f"{name}.png")
    labels = np.broadcast_to(ids, np.shape(found)).astype(np.uint8)
    Image.fromarray(labels).save(folder / "labels" / f"{name}.png")


@pytest.fixture
def photos(tmp_path):
    """Two photos whose overlaps are counted by hand below."""
    column = np.arange(SIZE[1]) * np.ones((SIZE[0], 1))
    # Found: columns 0-31. Road 16-39, pavement 40-47, void 48-63 and 0-7, else wall.
    ids = np.full(SIZE, 7)
    ids[:, 16:40], ids[:, 40:48], ids[:, 48:], ids[:, :8] = 3, 4, 11, 11
    write_photo(tmp_path / "photos", "a", column < 32, ids)
    write_photo(tmp_path / "photos", "b", column < 10, np.where(column < 20, 3, 7))
    return tmp_path / "photos"


@pytest.fixture
def kitti(tmp_path):
    """Four annotated images, and what the model finds: the same, worse from one to the next."""
    folder, pictures = tmp_path / "annotations", tmp_path / "pictures"
    folder.mkdir()
    pictures.mkdir()
    for i in range(4):
        ground, thing = np.zeros(SIZE, bool), np.zeros(SIZE, bool)
        ground[16:], thing[20:24, 10:30] = True, True
        for part, mask in (("ground", ground), ("objects", thing), ("combined", ground & ~thing)):
            Image.fromarray(mask).convert("L").save(folder / f"{i:05d}_{part}.png")
        found = ground & ~thing
        found[:, : 4 * i] = False
        picture(found & (np.arange(SIZE[1]) < 50), found).save(pictures / f"{i:05d}.png")
    return folder, pictures


def test_iou_over_images_and_over_all_their_pixels(run, green_is_ground, photos, tmp_path):
    done = run(
        photos,
        "--walkable",
        "3,4",
        "--void",
        "11",
        "--model",
        green_is_ground,
        "-o",
        tmp_path / "o",
    )
    assert done.exit_code == 0, done.stderr
    assert done.stdout == (tmp_path / "o" / "accuracy.md").read_text()
    report = json.loads((tmp_path / "o" / "accuracy.json").read_text())
    (summary,) = report["summaries"]["photos"].values()
    # a: both 16-31; either 8-47. b: both 0-9; either 0-19.
    assert summary["visible_ground"]["images"] == 2
    assert summary["visible_ground"]["mean"]["iou"] == pytest.approx((16 / 40 + 10 / 20) / 2)
    assert summary["visible_ground"]["pooled"]["iou"] == pytest.approx((16 + 10) / (40 + 20))
    assert "| Ours: green (fp32) | 0.450 |" in done.stdout
    assert "| Ours: green (fp32) | 0.433 |" in done.stdout


def test_a_photo_is_judged_at_its_own_size(run, green_is_ground, tmp_path):
    """Four times the model's size: as many pixels of border, not four times as many counted."""
    rows = np.arange(128)[:, None] * np.ones((1, 256))
    write_photo(tmp_path / "photos", "a", rows >= 64, np.where(rows >= 64, 3, 7))
    done = run(
        tmp_path / "photos", "--walkable", "3", "--model", green_is_ground, "-o", tmp_path / "o"
    )
    assert done.exit_code == 0, done.stderr
    scores = Results(tmp_path / "o" / "results.jsonl", settings_of(tmp_path / "o")).images
    ((_, counts),) = scores["photos/a"].items()
    assert counts.visible_ground.true == 64 * 256
    assert counts.visible_ground.iou > 0.95


def settings_of(out):
    return json.loads((out / "results.jsonl").read_text().splitlines()[0])["settings"]


def test_two_runs_say_the_same(run, green_is_ground, kitti, tmp_path):
    folder, pictures = kitti
    outs = [tmp_path / "first", tmp_path / "second"]
    for out in outs:
        done = run(
            folder, "--images", pictures, "--model", "edge", "--model", green_is_ground, "-o", out
        )
        assert done.exit_code == 0, done.stderr
    again = run(
        folder, "--images", pictures, "--model", "edge", "--model", green_is_ground, "-o", outs[0]
    )
    assert again.stdout == done.stdout
    for name in (*REPORTS, "results.jsonl"):
        assert (outs[0] / name).read_bytes() == (outs[1] / name).read_bytes(), name


def test_rows_are_those_of_the_models_and_what_the_paper_compares(
    run, green_is_ground, kitti, tmp_path
):
    folder, pictures = kitti
    done = run(folder, "--images", pictures, "--model", green_is_ground, "-o", tmp_path / "o")
    with (tmp_path / "o" / "per-image.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    ious = {
        row["image"]: float(row["freespace_iou"])
        for row in rows
        if row["method"] == "Ours: green (fp32)"
    }
    true = 48 * 16 + 16 * 16 - 4 * 20
    # what the model misses grows from image to image, and reaches the footprint in the last
    missed = [0, 4 * 16, 8 * 16, 12 * 16 - 2 * 4]
    expected = [(true - m) / true for m in missed]
    assert list(ious.values()) == pytest.approx(expected, abs=1e-12)
    # 4 images, and every row but those that need a depth or somebody's boxes and voxels
    assert {row["method"] for row in rows} >= {"Convex hull", "Visible ground", "Project down"}
    assert "Nothing traversable | 0.000 | 0.000" in done.stdout
    assert "3D bounding boxes: needs oriented boxes, --boxes FILE." in done.stdout
    assert "Voxel floor (SSCNet): needs the scene in voxels, --voxels FOLDER." in done.stdout
    assert "**" in done.stdout and "<u>" in done.stdout
    with Image.open(tmp_path / "o" / "worst.png") as sheet:
        assert sheet.width > 3 * 400 and sheet.height > 4 * 200


def test_boxes_and_voxels_make_rows(run, green_is_ground, kitti, tmp_path):
    folder, pictures = kitti
    box = {"centre_m": [0, 1, 3], "size_m": [1, 1, 1], "rotation": np.eye(3).tolist()}
    names = [f"annotations/{i:05d}" for i in range(4)]
    (tmp_path / "boxes.json").write_text(json.dumps({name: [box] for name in names}))
    labels = np.full((20, 20, 1), 2, np.uint8)
    pose = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 1.5], [0, 0, 0, 1]])
    (tmp_path / "voxels" / "annotations").mkdir(parents=True)
    for name in names[:3]:  # the fourth is one of those where the prediction of voxels failed
        np.savez(
            tmp_path / "voxels" / f"{name}.npz",
            labels=labels,
            origin_m=[-2, 1, -0.2],
            voxel_m=0.2,
            camera_to_grid=pose,
        )
    done = run(
        *(folder, "--images", pictures, "--model", green_is_ground, "-o", tmp_path / "o"),
        *("--boxes", tmp_path / "boxes.json", "--voxels", tmp_path / "voxels"),
    )
    assert done.exit_code == 0, done.stderr
    assert "| 3D bounding boxes † | " in done.stdout
    assert "| Voxel floor (SSCNet) † (3 of 4 images) | " in done.stdout


def test_an_image_that_fails_is_named_and_the_others_count(run, green_is_ground, kitti, tmp_path):
    folder, pictures = kitti
    whole = (pictures / "00002.png").read_bytes()
    (pictures / "00002.png").write_bytes(b"no picture")
    arguments = (folder, "--images", pictures, "--model", green_is_ground, "-o", tmp_path / "o")
    done = run(*arguments)
    assert done.exit_code == 1
    assert "annotations/00002" in done.stderr
    assert "3 images, 1 skipped" in done.stdout
    assert "- skipped annotations/00002: " in done.stdout
    # once it is there, only that one is left to do
    (pictures / "00002.png").write_bytes(whole)
    (pictures / "00000.png").unlink()
    (pictures / "00001.png").unlink()
    (pictures / "00003.png").unlink()
    done = run(*arguments)
    lines = (tmp_path / "o" / "results.jsonl").read_text().splitlines()
    assert [json.loads(line).get("image") for line in lines[1:]] == [
        f"annotations/{i:05d}" for i in (0, 1, 3, 2)
    ]
    assert "4 images" in (done.stdout + (tmp_path / "o" / "accuracy.md").read_text())


def test_a_stopped_run_goes_on_where_it_was(run, green_is_ground, kitti, tmp_path):
    folder, pictures = kitti
    arguments = (folder, "--images", pictures, "--model", green_is_ground)
    assert run(*arguments, "-o", tmp_path / "whole").exit_code == 0
    assert run(*arguments, "-o", tmp_path / "stopped").exit_code == 0
    file = tmp_path / "stopped" / "results.jsonl"
    lines = file.read_text().splitlines(keepends=True)
    marked = json.loads(lines[1])
    marked["scores"]["Ours: green (fp32)"]["freespace"]["overlap"] -= 100
    file.write_text(lines[0] + json.dumps(marked) + "\n" + lines[2][: len(lines[2]) // 2])
    for name in REPORTS:
        (tmp_path / "stopped" / name).unlink()
    assert run(*arguments, "-o", tmp_path / "stopped").exit_code == 0
    resumed = file.read_text().splitlines(keepends=True)
    assert json.loads(resumed[1]) == marked  # kept, not computed again
    assert resumed[2:] == lines[2:]
    assert run(*arguments, "-o", tmp_path / "stopped", "--fresh").exit_code == 0
    for name in REPORTS:
        assert (tmp_path / "stopped" / name).read_bytes() == (
            tmp_path / "whole" / name
        ).read_bytes()


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_an_interrupted_run_keeps_what_is_done(kitti, tmp_path):
    folder, pictures = kitti
    for i in range(4, 300):
        for part in ("ground", "combined"):
            (folder / f"{i:05d}_{part}.png").symlink_to(folder / f"00000_{part}.png")
        (pictures / f"{i:05d}.png").symlink_to(pictures / "00000.png")
    command = [sys.executable, "-m", "footprints_edge_bench.cli", "accuracy", str(folder)]
    out = tmp_path / "o"
    process = subprocess.Popen(
        [*command, "--images", str(pictures), "-o", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    file = out / "results.jsonl"
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not (file.exists() and file.read_text().count("\n") > 2):
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in errors
    done = file.read_text().count("\n") - 1
    assert 2 <= done < 300


def test_results_of_other_settings_are_refused(run, green_is_ground, photos, tmp_path):
    arguments = (photos, "--walkable", "3,4", "--model", green_is_ground, "-o", tmp_path / "o")
    assert run(*arguments).exit_code == 0
    done = run(*arguments, "--void", "11")
    assert done.exit_code == 2
    assert "other settings (void)" in done.stderr
    assert "--fresh" in done.stderr
    done = run(*arguments[:3], "--model", "edge", "-o", tmp_path / "o")
    assert done.exit_code == 2
    assert "(models)" in done.stderr
    assert run(*arguments, "--void", "11", "--fresh").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["absent"], 2, "absent"),
        (["photos"], 2, "--walkable"),
        (["photos", "--walkable", "road"], 2, "road"),
        (["photos", "--walkable", "3", "--model", "absent.onnx"], 3, "absent.onnx"),
        (["photos", "--walkable", "3", "--frames", "last"], 2, "0.8:1"),
        (["photos", "--walkable", "3", "--boxes", "absent.json"], 2, "absent.json"),
        (["photos", "--walkable", "3", "--voxels", "absent"], 2, "absent"),
        (["photos", "--walkable", "3", "--model", "edge", "--model", "edge"], 2, "two models"),
        ([], 2, "data"),
    ],
)
@pytest.mark.usefixtures("photos")
def test_what_is_wrong_is_said_in_a_line(run, tmp_path, monkeypatch, arguments, code, words):
    monkeypatch.chdir(tmp_path)
    done = run(*arguments)
    assert done.exit_code == code
    assert words in done.stderr
    assert not done.stdout


def test_results_are_refused_once_the_ground_truth_has_changed(
    run, green_is_ground, photos, tmp_path
):
    arguments = (photos, "--walkable", "3,4", "--model", green_is_ground, "-o", tmp_path / "o")
    assert run(*arguments).exit_code == 0
    write_photo(photos, "b", np.zeros(SIZE, bool), np.full(SIZE, 3))
    done = run(*arguments)
    assert done.exit_code == 2
    assert "other settings (ground_truth)" in done.stderr
    assert "1.000" not in done.stdout
