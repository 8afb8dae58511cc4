"""Checkpoints: what is refused, why, and that nothing of it ever runs."""

import os
import pickle
import random
import tracemalloc
import zipfile

import pytest
import torch
from torch import nn

from footprints_edge.errors import ModelError
from footprints_edge_models.networks.checkpoint import (
    FOCAL_PX_KEY,
    file_sha256,
    load_weights,
    read_checkpoint,
    stated_focal_px,
)


def network():
    return nn.Sequential(nn.Conv2d(3, 4, 1), nn.BatchNorm2d(4))


class RunsCode:
    """Makes a folder when it is unpickled."""

    def __init__(self, folder):
        self.folder = str(folder)

    def __reduce__(self):
        return os.mkdir, (self.folder,)


def test_what_was_saved_comes_back(tmp_path):
    torch.manual_seed(1)
    source, target = network(), network()
    torch.save(source.state_dict(), tmp_path / "a.pth")
    load_weights(target, read_checkpoint(tmp_path / "a.pth"), "a.pth")
    for key, tensor in source.state_dict().items():
        assert torch.equal(target.state_dict()[key], tensor), key


def test_missing_keys_are_named():
    weights = network().state_dict()
    del weights["0.bias"], weights["1.running_var"]
    with pytest.raises(ModelError, match=r"2 missing: 0\.bias, 1\.running_var") as caught:
        load_weights(network(), weights, "a.pth")
    assert "a.pth" in str(caught.value)
    assert "unexpected" not in str(caught.value)


def test_unexpected_keys_are_named():
    weights = network().state_dict() | {"extra.weight": torch.zeros(1)}
    with pytest.raises(ModelError, match=r"1 unexpected: extra\.weight"):
        load_weights(network(), weights, "a.pth")


def test_misshapen_keys_are_named_with_both_shapes():
    weights = network().state_dict() | {"0.weight": torch.zeros(4, 1, 1, 1)}
    with pytest.raises(ModelError, match=r"0\.weight \(4, 1, 1, 1\) instead of \(4, 3, 1, 1\)"):
        load_weights(network(), weights, "a.pth")


def test_all_problems_come_at_once_and_a_long_list_is_cut():
    weights = {f"strange.{i}": torch.zeros(1) for i in range(9)}
    with pytest.raises(ModelError, match=r"missing.*9 unexpected.* and 4 more"):
        load_weights(network(), weights, "a.pth")


def test_a_stated_focal_length_is_none_of_the_networks():
    weights = network().state_dict()
    assert stated_focal_px(weights, "a.pth") is None
    stated = weights | {FOCAL_PX_KEY: torch.tensor(312.5)}
    assert stated_focal_px(stated, "a.pth") == 312.5
    load_weights(network(), stated, "a.pth")


@pytest.mark.parametrize("focal_px", [torch.tensor(0.0), torch.tensor(float("nan")), "400"])
def test_a_focal_length_that_is_none_is_refused(focal_px):
    with pytest.raises(ModelError, match=r"a\.pth: canonical_focal_px"):
        stated_focal_px({FOCAL_PX_KEY: focal_px}, "a.pth")


def test_a_refused_checkpoint_changes_no_weight():
    target = network()
    before = {key: tensor.clone() for key, tensor in target.state_dict().items()}
    weights = {key: tensor + 1 for key, tensor in before.items()} | {"1.bias": torch.zeros(7)}
    with pytest.raises(ModelError):
        load_weights(target, weights, "a.pth")
    assert all(torch.equal(before[key], tensor) for key, tensor in target.state_dict().items())


def test_a_state_dict_nested_in_another_dict_is_told_what_to_save(tmp_path):
    torch.save({"state_dict": network().state_dict(), "epoch": 3}, tmp_path / "a.pth")
    with pytest.raises(ModelError, match="state dict of named tensors"):
        load_weights(network(), read_checkpoint(tmp_path / "a.pth"), "a.pth")


def test_a_whole_pickled_network_is_refused(tmp_path):
    torch.save(network(), tmp_path / "a.pth")
    with pytest.raises(ModelError, match=r"a\.pth.*state_dict\(\)"):
        read_checkpoint(tmp_path / "a.pth")


@pytest.mark.parametrize("is_zip", [True, False])
def test_a_checkpoint_that_would_run_code_does_not_run_it(tmp_path, is_zip):
    path, made = tmp_path / "evil.pth", tmp_path / "made-by-the-pickle"
    if is_zip:
        torch.save({"weight": RunsCode(made)}, path)
    else:
        path.write_bytes(pickle.dumps({"weight": RunsCode(made)}, protocol=2))
    with pytest.raises(ModelError, match=r"evil\.pth"):
        read_checkpoint(path)
    assert not made.exists()
    # The very same file does run its code where nobody guards against it.
    torch.load(path, weights_only=False) if is_zip else pickle.loads(path.read_bytes())
    assert made.is_dir()


def test_no_such_file(tmp_path):
    with pytest.raises(ModelError, match=r"absent\.pth: no such checkpoint"):
        read_checkpoint(tmp_path / "absent.pth")


def test_a_folder(tmp_path):
    with pytest.raises(ModelError, match=str(tmp_path.name)):
        read_checkpoint(tmp_path)


def test_an_empty_file(tmp_path):
    (tmp_path / "a.pth").touch()
    with pytest.raises(ModelError, match=r"a\.pth"):
        read_checkpoint(tmp_path / "a.pth")


@pytest.mark.parametrize(
    "text", ["<!DOCTYPE html><p>404</p>", "version https://git-lfs.github.com/spec/v1\n", "hello"]
)
def test_a_text_file(tmp_path, text):
    (tmp_path / "a.pth").write_text(text)
    with pytest.raises(ModelError, match=r"a\.pth"):
        read_checkpoint(tmp_path / "a.pth")


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_truncated_download(tmp_path, share):
    torch.save(network().state_dict(), tmp_path / "whole.pth")
    data = (tmp_path / "whole.pth").read_bytes()
    (tmp_path / "a.pth").write_bytes(data[: int(share * len(data))])
    with pytest.raises(ModelError, match=r"a\.pth.*damaged"):
        read_checkpoint(tmp_path / "a.pth")


@pytest.mark.parametrize("is_zip", [True, False])
def test_damaged_bytes_never_end_in_another_error(tmp_path, is_zip):
    """Whatever a damaged byte makes of the pickle, the user gets one kind of error."""
    path, rng, refused = tmp_path / "a.pth", random.Random(0), 0
    torch.save(network().state_dict(), path, _use_new_zipfile_serialization=is_zip)
    whole = path.read_bytes()
    for _ in range(150):
        damaged = bytearray(whole)
        for _ in range(5):
            damaged[rng.randrange(len(damaged))] = rng.randrange(256)
        path.write_bytes(damaged)
        try:
            read_checkpoint(path)
        except ModelError:
            refused += 1
    assert refused > 50


def test_a_zip_of_something_else(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.pth", "w") as archive:
        archive.writestr("readme.txt", "hello")
    with pytest.raises(ModelError, match=r"a\.pth"):
        read_checkpoint(tmp_path / "a.pth")


def test_sha256_is_that_of_the_standard(tmp_path):
    (tmp_path / "abc").write_bytes(b"abc")  # the example of FIPS 180-2
    assert file_sha256(tmp_path / "abc") == (
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    )


@pytest.mark.parametrize(
    "odd",
    [
        lambda tensor: tensor.to("meta"),
        lambda tensor: tensor.to_sparse(),
        lambda tensor: torch.quantize_per_tensor(tensor, 0.1, 0, torch.qint8),
        lambda tensor: tensor.to(torch.complex64),
        lambda tensor: tensor > 0,
    ],
    ids=["meta", "sparse", "quantised", "complex", "bool"],
)
def test_tensors_without_plain_numbers_are_named(odd):
    network = torch.nn.Linear(2, 3)
    weights = {**network.state_dict(), "weight": odd(network.weight.detach())}
    with pytest.raises(ModelError, match="no plain numbers: weight"):
        load_weights(network, weights, "odd.pth")
    with pytest.raises(ModelError, match=r"canonical_focal_px is"):
        stated_focal_px({"canonical_focal_px": odd(torch.tensor([300.0]))}, "odd.pth")


@pytest.mark.parametrize("value", [float("inf"), float("nan")])
def test_values_that_are_not_finite_are_named(value):
    network = torch.nn.Linear(2, 3)
    before = network.weight.detach().clone()
    weights = {**network.state_dict(), "bias": torch.tensor([1.0, value, 1.0])}
    with pytest.raises(ModelError, match="not finite: bias"):
        load_weights(network, weights, "odd.pth")
    assert torch.equal(network.weight, before)


def test_keys_in_messages_are_short_and_printable():
    network = torch.nn.Linear(2, 3)
    weights = {**network.state_dict(), "\x1b[2J": torch.zeros(1), "k" * 10**6: torch.zeros(1)}
    with pytest.raises(ModelError, match="2 unexpected") as caught:
        load_weights(network, weights, "odd.pth")
    assert len(str(caught.value)) < 500
    assert str(caught.value).isprintable()


def test_a_zip_that_unpacks_to_more_than_it_is_large_is_refused_unread(tmp_path):
    path = tmp_path / "bomb.pth"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("m/data.pkl", bytes(10**7))
        archive.writestr("m/version", "3\n")
    tracemalloc.start()
    with pytest.raises(ModelError, match="refused") as caught:
        read_checkpoint(path)
    assert "unpacks to 10000002 bytes" in str(caught.value.__cause__)
    assert tracemalloc.get_traced_memory()[1] < 10**6
    tracemalloc.stop()
