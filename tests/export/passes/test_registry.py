"""The passes on the networks: the same maps, and what onnxruntime makes of the files."""

from collections import Counter

import numpy as np
import onnx
import pytest
from PIL import Image

from footprints_edge_export.convert import convert
from footprints_edge_export.errors import VerificationError
from footprints_edge_export.graph.editing import constant, set_constant
from footprints_edge_export.passes.registry import PASSES, Pass, PassStage, apply_passes

SIZE = (64, 96)
HEADS = {"edge": 1, "reference": 2}


def use_passes(patch, passes):
    patch.setattr("footprints_edge_export.convert.PASSES", passes)


@pytest.fixture(scope="module", params=["edge", "reference"])
def plain(request, once, reference_files, edge_checkpoint, conversion, photos):
    """A network's name and its files as they are without passes: fp32 and int8."""
    name = request.param
    checkpoint = edge_checkpoint if name == "edge" else reference_files["checkpoint"]

    def make(folder):
        files = {}
        with pytest.MonkeyPatch.context() as patch:
            use_passes(patch, ())
            for precision in ("fp32", "int8"):
                files[precision] = folder / f"{precision}.onnx"
                calibration = (photos,) if precision == "int8" else ()
                wanted = conversion(name, SIZE, precision, calibration)
                convert(checkpoint, files[precision], wanted, overwrite=False)
        return files

    return name, once(f"plain-{name}", make)


@pytest.fixture(scope="module")
def pictures(photos):
    """The photos at the network's size, uint8 (1, H, W, 3) each."""
    return [
        np.asarray(Image.open(photo).convert("RGB").resize(SIZE[::-1]))[None]
        for photo in sorted(photos.iterdir())
    ]


@pytest.fixture(scope="module")
def plain_maps(plain, pictures, running):
    """What the files without passes make of the pictures, by precision."""
    _, files = plain
    loaded = {precision: running(onnx.load(path)) for precision, path in files.items()}
    return {precision: [give(p)[0] for p in pictures] for precision, give in loaded.items()}


@pytest.mark.parametrize("each", PASSES, ids=lambda each: each.name)
def test_each_pass_alone_keeps_the_maps(plain, plain_maps, pictures, running, rewritten, each):
    name, files = plain
    precisions = [each.stage.value] if each.stage != PassStage.FLOAT else ["fp32", "int8"]
    for precision in precisions:
        model = onnx.load(files[precision])
        faster = rewritten(each.rewrite, model)
        onnx.checker.check_model(faster, full_check=True)
        maps_of = running(faster)
        for picture, expected in zip(pictures[:3], plain_maps[precision], strict=False):
            (found,) = maps_of(picture)
            assert expected.std(axis=(2, 3)).min() > 1e-3
            if each.name == "elu_on_bytes" and name == "reference":
                continue  # not exact: the next test
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4)


def _all_int8_passes(model):
    apply_passes(model, PassStage.FLOAT)
    apply_passes(model, PassStage.INT8)


def test_all_passes_cost_int8_nothing(plain, plain_maps, pictures, running, rewritten):
    """Further from float than plain int8 is, they are not: their errors are of its own kind."""
    _, files = plain
    fast = running(rewritten(_all_int8_passes, onnx.load(files["int8"])))
    off, plain_off = [], []
    for picture, expected, int8 in zip(
        pictures, plain_maps["fp32"], plain_maps["int8"], strict=True
    ):
        off.append(np.abs(fast(picture)[0] - expected).mean())
        plain_off.append(np.abs(int8 - expected).mean())
    assert np.mean(off) <= 1.05 * np.mean(plain_off)


def test_onnxruntime_computes_all_but_the_heads_on_codes(
    plain, reference_files, optimised_nodes, rewritten, tmp_path
):
    """A new onnxruntime that no longer fuses what these files rely on is noticed here."""
    name, files = plain
    passed = tmp_path / "passed.onnx"
    model = onnx.load(files["int8"])
    onnx.save(rewritten(_all_int8_passes, model), passed)
    as_converted = files["int8"] if name == "edge" else reference_files["int8"]
    convolutions = [node for node in onnx.load(files["fp32"]).graph.node if node.op_type == "Conv"]
    for path in (as_converted, passed):
        kinds = Counter(node.op_type for node in optimised_nodes(path))
        assert kinds["QLinearConv"] == len(convolutions) - HEADS[name]
        assert kinds["Conv"] + kinds["FusedConv"] == HEADS[name]
        # Only what the heads read leaves the codes, and nothing comes back to them.
        assert kinds["DequantizeLinear"] == HEADS[name]
        assert kinds["QuantizeLinear"] == 0
        assert kinds["Elu"] == 0
        # One where the picture comes in, one before the heads: no other changes the layout.
        assert kinds["Transpose"] <= 2
    # Of the passed file; what is left is the edge network's bilinear one, of floats.
    assert kinds["Resize"] + kinds["Upsample"] == (1 if name == "edge" else 0)


def test_the_reference_file_is_converted_through_the_passes(reference_files):
    kinds = Counter(node.op_type for node in onnx.load(reference_files["fp32"]).graph.node)
    assert kinds["Elu"] == 0
    assert kinds["Exp"] == 36
    assert kinds["Slice"] == 2  # of the last upsampling
    assert kinds["DepthToSpace"] == 2
    kinds = Counter(node.op_type for node in onnx.load(reference_files["int8"]).graph.node)
    assert kinds["Elu"] == 0
    assert kinds["Resize"] == 0
    assert kinds["BatchNormalization"] == 0


def test_a_pass_that_changes_the_maps_is_refused(
    reference_files, conversion, tmp_path, monkeypatch
):
    """The float file is compared with torch after the passes, not before."""

    def spoilt(model):
        constants = model.graph.initializers.values()
        (bias,) = [value for value in constants if value.name.endswith("conv2d_79/bias")]
        set_constant(bias, constant(bias) + np.float32(0.01))

    use_passes(monkeypatch, (*PASSES, Pass(spoilt, PassStage.FP32)))
    output = tmp_path / "a.onnx"
    wanted = conversion("reference", SIZE)
    with pytest.raises(VerificationError, match="differs from torch"):
        convert(reference_files["checkpoint"], output, wanted, overwrite=False)
    assert not output.exists()
