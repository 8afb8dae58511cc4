"""Files with some of the maps, or of a coarser head: what is there is right, the rest is gone."""

import numpy as np
import onnx
import pytest
import torch
from typer.testing import CliRunner

from footprints_edge.errors import MissingMapError
from footprints_edge.model import load
from footprints_edge.model_files.metadata import OUTPUTS
from footprints_edge_export.cli import app
from footprints_edge_export.convert import convert
from footprints_edge_export.errors import ExportError
from footprints_edge_export.partial_networks import EdgePart, ReferencePart
from footprints_edge_models.networks.channels import raw_to_maps
from footprints_edge_models.networks.edge import EdgeNetwork

SIZE = (64, 96)


@pytest.fixture(scope="module")
def image():
    noise = torch.rand(1, 3, 12, 16, generator=torch.Generator().manual_seed(3))
    return torch.nn.functional.interpolate(noise, SIZE, mode="bicubic").clamp(0, 1)


@pytest.fixture(scope="module")
def two_decoders(edge_network):
    """The edge network with a coarse decoder that has a say; half precision holds its weights."""
    torch.manual_seed(1)
    network = EdgeNetwork(coarse_decoder=True)
    network.load_state_dict(edge_network.state_dict(), strict=False)
    torch.nn.init.normal_(network.coarse_head.weight, 0, 0.1)
    return network.half().float().eval()


@pytest.fixture(scope="module")
def checkpoints(edge_checkpoint, reference_files):
    return {"edge": edge_checkpoint, "reference": reference_files["checkpoint"]}


@pytest.mark.parametrize("outputs", OUTPUTS)
def test_part_of_edge_is_those_channels_of_the_whole(edge_network, image, outputs):
    with torch.no_grad():
        whole = raw_to_maps(edge_network(image))
        part = EdgePart(edge_network, outputs, 1)(image)
    assert whole.std(dim=(2, 3)).min() > 1e-3
    torch.testing.assert_close(part, whole[:, list(OUTPUTS[outputs])])


@pytest.mark.parametrize("outputs", OUTPUTS)
def test_part_of_two_decoders_is_those_channels_of_the_whole(two_decoders, image, outputs):
    with torch.no_grad():
        whole = raw_to_maps(two_decoders(image))
        part = EdgePart(two_decoders, outputs, 1)(image)
    torch.testing.assert_close(part, whole[:, list(OUTPUTS[outputs])])


def test_two_decoders_convert_as_their_weights_say(two_decoders, conversion, run, image, tmp_path):
    """Training keeps half precision; the file computes in single."""
    checkpoint, path = tmp_path / "weights.pt", tmp_path / "a.onnx"
    weights = two_decoders.state_dict()
    half = {k: v.half() if v.is_floating_point() else v for k, v in weights.items()}
    torch.save(half, checkpoint)
    convert(checkpoint, path, conversion(size=SIZE), overwrite=False)
    picture = (image * 255).byte()
    with torch.no_grad():
        expected = raw_to_maps(two_decoders(picture / 255))
    model = onnx.load(path)
    kinds = {tensor.data_type for tensor in model.graph.initializer}
    assert onnx.TensorProto.FLOAT16 not in kinds
    (maps,) = run(model, picture.permute(0, 2, 3, 1).numpy())
    np.testing.assert_allclose(maps, expected.numpy(), rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("scale", [1, 2, 4])
@pytest.mark.parametrize("outputs", OUTPUTS)
def test_part_of_reference_is_those_channels_of_that_head(reference_network, image, outputs, scale):
    with torch.no_grad():
        whole = raw_to_maps(reference_network.scales(image)[f"1/{scale}"])
        part = ReferencePart(reference_network, outputs, scale)(image)
    torch.testing.assert_close(part, whole[:, list(OUTPUTS[outputs])])


@pytest.fixture(scope="module")
def partial(once, checkpoints, conversion, photos):
    """The function that gives a file of (64, 96), and its report."""

    def give(architecture, precision, outputs, scale=1):
        calibration = (photos,) if precision == "int8" else ()
        wanted = conversion(
            architecture, SIZE, precision, calibration, outputs=outputs, scale=scale
        )

        def make(folder):
            path = folder / "part.onnx"
            return path, convert(checkpoints[architecture], path, wanted, overwrite=False)

        return once(f"part-{architecture}-{precision}-{outputs}-{scale}", make)

    return give


@pytest.mark.parametrize("precision", ["fp32", "int8"])
@pytest.mark.parametrize(
    ("architecture", "outputs", "scale"),
    [
        ("edge", "masks", 1),
        ("reference", "depths", 4),
    ],
)
def test_what_is_not_asked_for_is_not_in_the_file(
    partial, edge_fixed, reference_files, run, image, precision, architecture, outputs, scale
):
    path, report = partial(architecture, precision, outputs, scale)
    assert report.scale == scale
    assert report.metadata["outputs"] == outputs
    model = onnx.load(path)
    channels = len(OUTPUTS[outputs])
    shape = [dim.dim_value for dim in model.graph.output[0].type.tensor_type.shape.dim]
    assert shape == [1, channels, *SIZE]
    picture = (image * 255).byte().permute(0, 2, 3, 1).numpy()
    (maps,) = run(model, picture)
    assert maps.shape == (1, channels, *SIZE)
    assert maps.std(axis=(2, 3)).min() > 1e-3
    if architecture == "reference":
        assert path.stat().st_size < 0.95 * reference_files[precision].stat().st_size
    elif precision == "fp32":
        (expected,) = run(onnx.load(edge_fixed[0]), picture)
        np.testing.assert_allclose(maps, expected[:, list(OUTPUTS[outputs])], atol=1e-4)


def test_a_file_without_depths_gives_masks_and_says_what_it_lacks(partial, tmp_path):
    path, _ = partial("edge", "fp32", "masks")
    picture = np.random.default_rng(0).integers(0, 256, (*SIZE, 3), np.uint8)
    prediction = load(path, threads=1).predict(picture)
    assert prediction.map_size == SIZE
    assert prediction.hidden_ground.shape == SIZE
    assert prediction.has("ground_probability") and not prediction.has("visible_depth_m")
    large = prediction.at_size((192, 256))
    assert large.ground.shape == (192, 256)
    for each in (prediction, large):
        for name in ("visible_depth_m", "unmasked_ground_depth_m", "ground_depth_m"):
            with pytest.raises(MissingMapError, match=r"no depths.*--outputs masks"):
                getattr(each, name)
    with pytest.raises(AttributeError, match="nonsense"):
        prediction.nonsense  # noqa: B018
    prediction.save(tmp_path, ["npz", "json"], name="a")
    with np.load(tmp_path / "a.npz") as arrays:
        assert "ground" in arrays and "visible_depth_m" not in arrays
    with pytest.raises(MissingMapError):
        prediction.save(tmp_path, ["overlay"], name="a")


def test_a_file_without_masks_gives_depths(partial, tmp_path):
    path, _ = partial("reference", "fp32", "depths", 4)
    prediction = load(path, threads=1).predict(np.zeros((*SIZE, 3), np.uint8))
    assert prediction.at_size((50, 60)).visible_depth_m.shape == (50, 60)
    for name in ("ground", "visible_ground", "hidden_ground", "ground_depth_m"):
        with pytest.raises(MissingMapError, match="no masks"):
            getattr(prediction, name)
    prediction.save(tmp_path, ["npz", "json"], name="a")
    with np.load(tmp_path / "a.npz") as arrays:
        assert "visible_depth_m" in arrays and "ground" not in arrays


def test_the_edge_network_has_one_head(checkpoints, conversion, tmp_path):
    with pytest.raises(ExportError, match="scale 2: edge has trained heads of scale 1 only"):
        convert(checkpoints["edge"], tmp_path / "a.onnx", conversion(scale=2), overwrite=False)
    command = ["convert", str(checkpoints["edge"]), "-o", str(tmp_path / "a.onnx")]
    result = CliRunner().invoke(app, [*command, "--arch", "edge", "--scale", "4"])
    assert result.exit_code == 2
    assert "scale 4" in result.stderr
    assert list(tmp_path.iterdir()) == []
