"""Test vectors: what is in them, what passes, and that a port with a usual mistake does not."""

import json
import shutil

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import footprints_edge as fp
from footprints_edge.inputs.images import decode
from footprints_edge_export import cli
from footprints_edge_export.errors import ExportError
from footprints_edge_export.verification.check_vectors import check_vectors
from footprints_edge_export.verification.test_vectors import (
    EXAMPLE_PHOTO,
    MASKS,
    METRES,
    derived,
    vector_images,
    write_vectors,
)
from footprints_edge_export.verification.vector_metres import (
    CELL_M,
    NAMES,
    RANGE_M,
    judge_path,
    metres,
    prediction_of,
)

MOST_BYTES = 13e6


@pytest.fixture(scope="module")
def model():
    """The bundled model, of which no sum saturates on any processor."""
    return fp.load(threads=1, session_options={"session.x64quantprecision": "1"})


@pytest.fixture(scope="module")
def vectors(model, once):
    """The vectors of the bundled model."""

    def make(folder):
        write_vectors(model, folder)
        return folder

    return once("vectors", make)


@pytest.fixture(scope="module")
def manifest(vectors):
    return json.loads((vectors / "vectors.json").read_text())


def expected(vectors, entry, name):
    path = vectors / entry["files"][name]
    return np.load(path) if path.suffix == ".npy" else np.asarray(Image.open(path))


def write_port(folder, vectors, manifest, port):
    """What a port writes: `port` gives arrays by name from a vector's entry and its input."""
    for entry in manifest["vectors"]:
        (folder / entry["name"]).mkdir(parents=True)
        for name, array in port(entry, expected(vectors, entry, "input")).items():
            if isinstance(array, dict):
                (folder / entry["name"] / f"{name}.json").write_text(json.dumps(array))
            else:
                np.save(folder / entry["name"] / f"{name}.npy", array)
    return folder


def with_ground(manifest):
    """All vectors but the wall."""
    return [entry for entry in manifest["vectors"] if entry["name"] != "wall"]


def failing(findings):
    return {finding.quantity for finding in findings if not finding.holds}


def test_the_vectors_hold_against_themselves(vectors):
    findings = check_vectors(vectors, vectors)
    assert failing(findings) == set()
    assert len(findings) > 40


def test_the_vectors_are_few_and_small(vectors, manifest):
    files = [path for path in vectors.rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) < MOST_BYTES
    shapes = [tuple(entry["image_size_px"]) for entry in manifest["vectors"]]
    assert any(h < w for h, w in shapes)
    assert any(h > w for h, w in shapes)
    assert any(h == w for h, w in shapes)
    assert any(h < 64 for h, w in shapes)
    listed = {vectors / file for entry in manifest["vectors"] for file in entry["files"].values()}
    assert listed | {vectors / "vectors.json"} == set(files)


def test_each_vector_has_ground_seen_and_hidden_and_something_else(vectors, manifest):
    """Else a port that finds ground everywhere, or nowhere, would pass."""
    for entry in with_ground(manifest):
        for mask in MASKS:
            share = (expected(vectors, entry, mask) > 0).mean()
            assert 0.01 < share < 0.8, (entry["name"], mask)


def test_arrays_are_of_the_contract(vectors, manifest):
    for entry in manifest["vectors"]:
        H, W = entry["image_size_px"]
        h, w = entry["network_size_px"]
        assert (h % 32, w % 32) == (0, 0)
        assert expected(vectors, entry, "image").shape == (H, W, 3)
        for name, shape, dtype in (
            ("input", (1, h, w, 3), np.uint8),
            ("maps", (1, 4, h, w), np.float32),
            ("visible_depth_m", (h, w), np.float32),
            ("ground_depth_m", (h, w), np.float32),
            ("hidden_ground", (h, w), np.uint8),
            ("hidden_ground_at_image_size", (H, W), np.uint8),
        ):
            array = expected(vectors, entry, name)
            assert (array.shape, array.dtype) == (shape, dtype), name


def test_the_runtime_gives_what_the_vectors_say(model, vectors, manifest):
    """`predict`, which is not what wrote them, on the vector of the size that the rule gives."""
    entry = next(e for e in manifest["vectors"] if e["name"] == "landscape")
    camera = fp.Intrinsics(**entry["image_intrinsics_px"])
    image = vectors / entry["files"]["image"]
    prediction = model.predict(image, intrinsics=camera, flatten=False)
    assert list(prediction.map_size) == entry["network_size_px"]
    at_image_size = prediction.at_image_size()
    for name in MASKS:
        np.testing.assert_array_equal(
            getattr(prediction, name), expected(vectors, entry, name) > 0, name
        )
        np.testing.assert_array_equal(
            getattr(at_image_size, name), expected(vectors, entry, f"{name}_at_image_size") > 0
        )
    for name in METRES:
        np.testing.assert_allclose(
            getattr(prediction, name), expected(vectors, entry, name), rtol=1e-6
        )


def test_cameras_are_those_of_the_photo(manifest):
    """Pieces of one photo see a point in its direction: at its own pixel of each."""
    photo = decode(EXAMPLE_PHOTO)
    camera = fp.Intrinsics.from_focal_35mm(photo.focal_35mm, photo.size)
    height, width = photo.size
    x, y = width - 100, height - 50  # in every piece, or below the wall
    direction = np.array([(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy])
    for entry, subject in zip(manifest["vectors"], vector_images(photo), strict=True):
        side, up = entry["image_size_px"][1], entry["image_size_px"][0]
        rows = height // 4 if subject.name == "wall" else height
        fraction = side / up * rows  # width of the piece in the photo
        u = (x + 0.5 - (width - fraction)) / fraction * side - 0.5
        v = (y + 0.5) / rows * up - 0.5
        found = entry["image_intrinsics_px"]
        seen = np.array([(u - found["cx"]) / found["fx"], (v - found["cy"]) / found["fy"]])
        np.testing.assert_allclose(seen, direction, atol=2e-3)
        assert subject.name == entry["name"]


def port_of(
    model,
    manifest,
    *,
    change_input=None,
    change_maps=None,
    change=None,
    scale=None,
    metres_too=False,
):
    """A port that is right but for one mistake."""

    def port(entry, network_input):
        seen = network_input if change_input is None else change_input(network_input)
        maps = model.engine.run(np.ascontiguousarray(seen))
        maps = maps if change_maps is None else change_maps(maps)
        facts = entry | {"depth_range_m": scale} if scale else entry
        results = derived(maps, facts, manifest["threshold"])
        if metres_too:
            results |= metres(prediction_of(maps, facts, manifest["threshold"]), facts)
        return {"input": seen, "maps": maps} | (
            results if change is None else change(results, maps)
        )

    return port


def test_a_right_port_passes(model, vectors, manifest, tmp_path):
    port = port_of(model, manifest, metres_too=True)
    outputs = write_port(tmp_path / "port", vectors, manifest, port)
    findings = check_vectors(vectors, outputs)
    assert failing(findings) == set()
    assert set(NAMES[:-1]) <= {finding.quantity for finding in findings if finding.checked}


def at_threshold(value):
    def change(results, maps):
        visible, ground = maps[0, :2] > value
        return results | dict(zip(MASKS, (visible, ground, ground & ~visible), strict=True))

    return change


def lowered(image):
    """Nearest neighbours: a resize without antialiasing."""
    small = image[0, ::2, ::2]
    return np.repeat(np.repeat(small, 2, 0), 2, 1)[None]


MISTAKES = {
    "BGR": ({"change_input": lambda x: x[..., ::-1]}, {"input", "maps[0]", "visible_ground"}),
    "a resize without antialiasing": ({"change_input": lowered}, {"input", "maps[0]"}),
    "rows from the bottom": ({"change_input": lambda x: x[:, ::-1]}, {"input", "maps[1]"}),
    "visible ground and ground swapped": (
        {"change_maps": lambda maps: maps[:, [1, 0, 2, 3]]},
        {"maps[0]", "maps[1]", "visible_ground", "ground"},
    ),
    "depths swapped": (
        {"change_maps": lambda maps: maps[:, [0, 1, 3, 2]]},
        {"maps[2] as depth", "maps[3] as depth"},
    ),
    "masks after depths": (
        {"change_maps": lambda maps: maps[:, [2, 3, 0, 1]]},
        {"maps[0]", "maps[2] as depth", "ground"},
    ),
    "no threshold": (
        {"change": at_threshold(0)},
        {"ground of the port's maps", "visible_ground of the port's maps", "ground"},
    ),
    "a threshold of 0.62": ({"change": at_threshold(0.62)}, {"ground of the port's maps"}),
    "hidden ground that is all ground": (
        {"change": lambda results, _: results | {"hidden_ground": results["ground"]}},
        {"hidden_ground of the port's maps"},
    ),
    "no camera": (
        {"scale": [0.1, 100.0]},
        {f"{name} of the port's maps" for name in METRES},
    ),
    "ground depth where there is none": (
        {"change": lambda results, _: results | {"ground_depth_m": results["visible_depth_m"]}},
        {"ground_depth_m of the port's maps"},
    ),
    "maps that are not numbers": ({"change_maps": lambda maps: maps * np.nan}, {"maps"}),
    "maps turned": (
        {"change": lambda results, maps: results | {"maps": maps.transpose(0, 2, 3, 1)}},
        {"maps"},
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_port_with_a_mistake_fails(mistake, model, vectors, manifest, tmp_path):
    options, caught = MISTAKES[mistake]
    port = port_of(model, manifest, **options)
    outputs = write_port(tmp_path / "port", vectors, manifest, port)
    findings = check_vectors(vectors, outputs)
    assert caught <= failing(findings)
    for entry in with_ground(manifest):  # each vector on its own would show it
        assert failing(f for f in findings if f.vector == entry["name"]), entry["name"]


def test_a_path_that_cuts_a_corner_is_over_closed_cells(vectors, manifest):
    """Two cells that meet in a corner of a closed one, away from the ends."""
    entry = next(e for e in manifest["vectors"] if e["name"] == "landscape")
    prediction = prediction_of(expected(vectors, entry, "maps"), entry, manifest["threshold"])
    grid = prediction.top_down(CELL_M, RANGE_M)
    blocks = np.lib.stride_tricks.sliding_window_view(grid.walkable, (2, 2))
    corners = np.argwhere(
        blocks[..., 0, 0] & blocks[..., 1, 1] & ~blocks[..., 0, 1] & blocks[..., 1, 0]
    )
    row, column = corners[len(corners) // 2]
    over_m = grid.places_m[[row, row + 1], [column, column + 1]]
    round_m = np.insert(over_m, 1, grid.places_m[row + 1, column], axis=0)
    assert judge_path(prediction, over_m, entry).closed_m > 0
    assert judge_path(prediction, round_m, entry).closed_m == 0


def test_what_a_port_does_not_write_fails_or_is_left_out(vectors, tmp_path):
    outputs = tmp_path / "port"
    shutil.copytree(vectors, outputs)
    (outputs / "square" / "ground.png").unlink()
    (outputs / "tiny" / "input.npy").unlink()
    (outputs / "tiny" / "ground_at_image_size.png").unlink()
    shutil.rmtree(outputs / "portrait")
    findings = [finding for finding in check_vectors(vectors, outputs) if not finding.holds]
    assert {finding.vector for finding in findings} == {"square", "portrait"}
    assert {f.quantity for f in findings if f.vector == "square"} == {"ground"}
    assert "not written" in str(findings[0])


def test_a_damaged_output_is_a_finding_and_no_crash(vectors, tmp_path):
    outputs = tmp_path / "port"
    shutil.copytree(vectors, outputs)
    (outputs / "tiny" / "ground.png").write_bytes(b"no picture")
    (outputs / "tiny" / "maps.npy").write_bytes(b"no array")
    assert failing(check_vectors(vectors, outputs)) == {"ground", "maps"}


def test_openvino_passes_where_no_sum_saturates(vectors, manifest, tmp_path):
    """Either engine saturates on x86 without VNNI, in its own order, unless it is told not to."""
    pytest.importorskip("openvino", reason="the extra openvino is not installed")
    in_floats = {"LP_TRANSFORMS_MODE": "NO"}
    port = port_of(fp.load(engine="openvino", threads=1, session_options=in_floats), manifest)
    outputs = write_port(tmp_path / "port", vectors, manifest, port)
    assert failing(check_vectors(vectors, outputs)) == set()


def test_a_file_of_fixed_size_has_vectors_of_that_size(edge_fixed, tmp_path):
    path, _ = edge_fixed
    write_vectors(fp.load(path, threads=1), tmp_path)
    written = json.loads((tmp_path / "vectors.json").read_text())
    assert {tuple(entry["network_size_px"]) for entry in written["vectors"]} == {(64, 96)}
    assert written["model"]["fixed_size_px"] == [64, 96]
    assert failing(check_vectors(tmp_path, tmp_path)) == set()


def test_the_command_prints_the_files_and_the_check_exits_with_1(tmp_path):
    run = CliRunner().invoke
    done = run(cli.app, ["vectors", "edge", "-o", str(tmp_path / "v")])
    assert done.exit_code == 0, done.output
    assert all((tmp_path / line).is_file() for line in done.stdout.splitlines())
    shutil.copytree(tmp_path / "v", tmp_path / "port")
    arguments = ["check-vectors", str(tmp_path / "v"), str(tmp_path / "port")]
    assert run(cli.app, arguments).exit_code == 0
    maps = np.load(tmp_path / "port" / "tiny" / "maps.npy")
    np.save(tmp_path / "port" / "tiny" / "maps.npy", maps[:, ::-1])
    done = run(cli.app, arguments)
    assert done.exit_code == 1
    assert "DIFFERS tiny: maps[0]" in done.stdout
    assert "DIFFERS landscape" not in done.stdout


def plane_of(vectors, entry):
    return json.loads((vectors / entry["files"]["ground_plane"]).read_text())


def test_the_vectors_hold_every_way_to_a_plane(vectors, manifest):
    """Nothing known, a part, all of it, and a gate that refuses."""
    of = {entry["name"]: entry for entry in manifest["vectors"]}
    known = {name: [*entry["known_pose"].values()] for name, entry in of.items()}
    assert known["landscape"] == [None] * 3
    assert known["portrait"].count(None) == known["square"].count(None) - 1 == 1
    assert None not in known["known_pose"]
    plane = plane_of(vectors, of["known_pose"])
    assert [plane[key] for key in of["known_pose"]["known_pose"]] == pytest.approx(
        known["known_pose"]
    )
    assert plane_of(vectors, of["refused"]) == {"refused": "impossible_pose"}
    assert plane_of(vectors, of["wall"]) == {"refused": "no_ground"}
    for name, entry in of.items():
        metres_too = set(NAMES[2:]) & set(entry["files"])
        assert metres_too == (set() if name in {"refused", "wall"} else set(NAMES[2:]))


def test_the_metres_are_those_of_predict(model, vectors, manifest):
    entry = next(e for e in manifest["vectors"] if e["name"] == "landscape")
    camera = fp.Intrinsics(**entry["image_intrinsics_px"])
    prediction = model.predict(vectors / entry["files"]["image"], intrinsics=camera)
    plane = plane_of(vectors, entry)
    assert plane["camera_height_m"] == pytest.approx(prediction.ground_plane().camera_height_m)
    flat_m = expected(vectors, entry, "flat_ground_depth_m")
    np.testing.assert_allclose(prediction.ground_depth_m, flat_m, rtol=1e-5)
    grid = prediction.top_down(entry["grid"]["cell_m"], entry["grid"]["range_m"])
    assert grid.cells.shape == (entry["grid"]["rows"], entry["grid"]["columns"])
    assert (grid.cells == expected(vectors, entry, "occupancy")).mean() > 0.999
    wanted = entry["path"]
    path = prediction.plan(wanted["start_px"], wanted["goal_px"], margin_m=wanted["margin_m"])
    # a place in pixels has few digits, which is a millimetre or so
    assert path.cost == pytest.approx(wanted["cost"], rel=1e-3, abs=2e-3)
    assert path.length_m == pytest.approx(wanted["length_m"], rel=1e-3, abs=2e-3)


def wrong_plane(plane):
    return plane | ({} if plane["refused"] else {"camera_height_m": plane["camera_height_m"] * 1.2})


def unlaid(results):
    return {"flat_ground_depth_m": results["ground_depth_m"]}


def mirrored(name, axis):
    return lambda results: {name: np.flip(results[name], axis)} if name in results else {}


METRE_MISTAKES = {
    "another height": (
        lambda results: {"ground_plane": wrong_plane(results["ground_plane"])},
        "ground_plane",
    ),
    "a plane where there is none": (
        lambda results: {"ground_plane": results["ground_plane"] | {"refused": "few_pixels"}},
        "ground_plane",
    ),
    "depth that is not laid flat": (unlaid, "flat_ground_depth_m"),
    "left and right of the grid": (mirrored("occupancy", 1), "occupancy"),
    "left and right of the scan": (mirrored("scan_m", 0), "scan_m"),
    "left and right of the ranges": (mirrored("nearest_obstacle_m", 0), "nearest_obstacle_m"),
    "a path back": (mirrored("path_m", 0), "path_m"),
    "a path aside": (
        lambda r: {"path_m": r["path_m"] + 0.3} if "path_m" in r else {},
        "path_m",
    ),
}


@pytest.fixture(scope="module")
def small(vectors, manifest, tmp_path_factory):
    """The small vectors alone, and their manifest."""
    folder = tmp_path_factory.mktemp("small")
    names = ("tiny", "known_pose", "refused")
    few = manifest | {"vectors": [e for e in manifest["vectors"] if e["name"] in names]}
    for name in names:
        (folder / name).symlink_to(vectors / name)
    (folder / "vectors.json").write_text(json.dumps(few))
    return folder, few


@pytest.mark.parametrize("mistake", METRE_MISTAKES)
def test_metres_with_a_mistake_fail(mistake, small, tmp_path):
    vectors, manifest = small
    change, caught = METRE_MISTAKES[mistake]

    def port(entry, _):
        found = {
            name: plane_of(vectors, entry)
            if name == "ground_plane"
            else expected(vectors, entry, name)
            for name in entry["files"]
            if name != "image"
        }
        return found | change(found)

    findings = check_vectors(vectors, write_port(tmp_path / "port", vectors, manifest, port))
    assert f"{caught} of the port's maps" in failing(findings)
    others = {quantity for quantity in failing(findings) if not quantity.startswith(caught)}
    assert others == set()


def test_metres_that_a_port_does_not_write_are_named(vectors, tmp_path):
    outputs = tmp_path / "port"
    shutil.copytree(vectors, outputs)
    for name in NAMES:
        for path in outputs.glob(f"*/{name}.*"):
            path.unlink()
    findings = check_vectors(vectors, outputs)
    assert failing(findings) == set()
    assert {f.quantity for f in findings if not f.checked} == set(NAMES)
    assert all(str(f).startswith("not checked") for f in findings if not f.checked)
    done = CliRunner().invoke(cli.app, ["check-vectors", str(vectors), str(outputs)])
    assert (done.exit_code, "34 not checked" in done.stderr) == (0, True), done.stderr


def test_a_plane_without_its_numbers_is_a_finding(vectors, tmp_path):
    outputs = tmp_path / "port"
    shutil.copytree(vectors, outputs)
    (outputs / "tiny" / "ground_plane.json").write_text('{"refused": null, "up": [0, -1]}')
    (outputs / "square" / "ground_plane.json").write_text("[1]")
    assert failing(check_vectors(vectors, outputs)) == {"ground_plane"}


def test_a_folder_that_holds_no_vectors_is_a_usage_error(tmp_path):
    done = CliRunner().invoke(cli.app, ["check-vectors", str(tmp_path), str(tmp_path)])
    assert done.exit_code == 2
    assert "fp-export vectors" in done.stderr


def test_vectors_of_another_format_are_refused(vectors, manifest, tmp_path):
    (tmp_path / "vectors.json").write_text(json.dumps(manifest | {"format": 99}))
    with pytest.raises(ExportError, match="format 99"):
        check_vectors(tmp_path, vectors)


def test_a_photo_that_is_not_there_is_named(model, tmp_path):
    with pytest.raises(ExportError, match=r"gone\.jpg.*--photo"):
        write_vectors(model, tmp_path, tmp_path / "gone.jpg")
