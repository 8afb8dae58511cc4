from dataclasses import replace

import pytest

from footprints_edge.errors import ModelError
from footprints_edge.model_files.metadata import OUTPUTS, ModelMetadata


@pytest.mark.parametrize("focal_px", [None, 400.0, 123.456789])
@pytest.mark.parametrize("depth_range_m", [(0.1, 100.0), (0.25, 80.5)])
def test_props_round_trip(focal_px, depth_range_m, metadata):
    expected = replace(metadata, focal_px=focal_px, depth_range_m=depth_range_m)
    props = expected.to_props()
    assert ModelMetadata.from_props(props | {"other": "entry"}, "m.onnx") == expected


def test_props_are_the_contracts(metadata):
    props = replace(metadata, focal_px=400.0).to_props()
    assert all(isinstance(value, str) for value in props.values())
    keys = "format name architecture precision depth_range_m camera resize licence source_sha256"
    expected = [f"footprints.{key}" for key in (*keys.split(), "producer", "training")]
    assert sorted(props) == sorted(expected)
    assert props["footprints.depth_range_m"] == "0.1,100"
    assert props["footprints.camera"] == "focal_px=400.0"
    assert metadata.to_props()["footprints.camera"] == "none"


def test_missing_keys_are_named_with_the_command_that_helps(metadata):
    props = metadata.to_props()
    del props["footprints.camera"], props["footprints.resize"]
    with pytest.raises(
        ModelError, match=r"m\.onnx lacks .*footprints\.camera, footprints\.resize.*fp-export"
    ):
        ModelMetadata.from_props(props, "m.onnx")


def test_a_foreign_file_is_called_one():
    with pytest.raises(
        ModelError, match=r"not one of footprints-edge.*fp-export convert CHECKPOINT"
    ):
        ModelMetadata.from_props({"author": "someone"}, "m.onnx")


@pytest.mark.parametrize(
    ("version", "advice"), [("2", "pip install --upgrade"), ("0", "fp-export"), ("x", "fp-export")]
)
def test_other_formats_are_refused(version, advice, metadata):
    with pytest.raises(ModelError, match=advice):
        ModelMetadata.from_props(metadata.to_props() | {"footprints.format": version}, "m.onnx")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("depth_range_m", "100"),
        ("depth_range_m", "100,0.1"),
        ("depth_range_m", "0,100"),
        ("depth_range_m", "0.1,inf"),
        ("camera", "focal_px=-4"),
        ("camera", "focal_px="),
        ("camera", "400"),
    ],
)
def test_unreadable_values_are_refused(key, value, metadata):
    with pytest.raises(ModelError, match=key):
        ModelMetadata.from_props(metadata.to_props() | {f"footprints.{key}": value}, "m.onnx")


@pytest.mark.parametrize("outputs", OUTPUTS)
def test_only_a_file_that_lacks_maps_says_which_it_has(metadata, outputs):
    props = replace(metadata, outputs=outputs).to_props()
    assert props.get("footprints.outputs", "all") == outputs
    assert ("footprints.outputs" in props) == (outputs != "all")
    assert ModelMetadata.from_props(props, "a.onnx").outputs == outputs


def test_unknown_outputs_are_refused(metadata):
    props = metadata.to_props() | {"footprints.outputs": "normals"}
    with pytest.raises(ModelError, match=r"a\.onnx.*'normals'.*all, masks, depths"):
        ModelMetadata.from_props(props, "a.onnx")
