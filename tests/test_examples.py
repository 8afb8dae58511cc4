"""The example programs, held against the test vectors of the bundled model."""

import ast
import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import onnxruntime
import pytest
from model_facts import stated, states
from painted_room import painted
from PIL import Image, ImageOps

import footprints_edge as fp
from footprints_edge_export.verification.check_vectors import check_vectors
from footprints_edge_export.verification.test_vectors import write_vectors

CHECKOUT = Path(__file__).resolve().parents[1]
EXAMPLES = CHECKOUT / "examples"
ROOM = EXAMPLES / "room.jpg"


@pytest.fixture(scope="module")
def model():
    return fp.load(threads=1)


@pytest.fixture(scope="module")
def vectors(model, tmp_path_factory):
    folder = tmp_path_factory.mktemp("vectors")
    write_vectors(model, folder)
    return folder


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """A model and the vectors of a painted room, whose maps no engine rounds."""
    folder = tmp_path_factory.mktemp("painted")
    model, photo = painted(folder)
    write_vectors(model, folder / "vectors", photo)
    return model, folder / "vectors"


def run(*words, **options):
    return subprocess.run(
        [*map(str, words)], check=True, capture_output=True, text=True, timeout=300, **options
    )


def imported(path):
    """A program, or a script of the tests, as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MINIMAL = imported(EXAMPLES / "embed_minimal.py")


def differing(vectors, outputs):
    findings = check_vectors(vectors, outputs)
    assert "input" in {finding.quantity for finding in findings}
    return [str(finding) for finding in findings if not finding.holds]


def test_the_minimal_program_is_short_and_needs_three_packages():
    text = (EXAMPLES / "embed_minimal.py").read_text()
    assert len(text.splitlines()) <= 180
    imports = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Import | ast.ImportFrom)]
    names = {getattr(n, "module", None) or n.names[0].name for n in imports}
    assert names - set(sys.stdlib_module_names) == {"numpy", "onnxruntime", "PIL"}


@pytest.fixture(scope="module")
def minimal_outputs(model, vectors, tmp_path_factory):
    """What the minimal program makes of the vectors."""
    folder = tmp_path_factory.mktemp("minimal")
    run(sys.executable, EXAMPLES / "embed_minimal.py", model.path, vectors, folder)
    return folder


def test_the_minimal_program_gives_the_vectors(vectors, minimal_outputs):
    assert differing(vectors, minimal_outputs) == []


def test_the_minimal_program_gives_a_painted_room(room, tmp_path):
    model, vectors = room
    run(sys.executable, EXAMPLES / "embed_minimal.py", model.path, vectors, tmp_path)
    assert differing(vectors, tmp_path) == []


def test_the_minimal_program_takes_a_picture(model, tmp_path):
    run(sys.executable, EXAMPLES / "embed_minimal.py", model.path, ROOM, cwd=tmp_path)
    assert Image.open(tmp_path / "ground.png").size == Image.open(ROOM).size
    depth_m = np.load(tmp_path / "ground_depth_m.npy")
    ground = model.predict(ROOM).ground
    assert (np.isfinite(depth_m) & ground).sum() / (np.isfinite(depth_m) | ground).sum() > 0.9


@pytest.mark.parametrize("upright", [False, True])
@pytest.mark.parametrize("photo", ["room.jpg", "office.jpg"])
def test_the_minimal_program_says_the_metres_of_fp_infer(
    photo, upright, model, tmp_path, monkeypatch
):
    path = EXAMPLES / photo
    if upright:  # another shape, by the same camera
        image = Image.open(path)
        path = tmp_path / "piece.png"
        image.crop((0, 0, 3 * image.height // 4, image.height)).save(path, exif=image.getexif())
    monkeypatch.chdir(tmp_path)
    session = onnxruntime.InferenceSession(model.path, providers=["CPUExecutionProvider"])
    monkeypatch.setattr(MINIMAL, "session", session, raising=False)
    monkeypatch.setattr(sys, "argv", ["embed_minimal.py", str(model.path), str(path)])
    MINIMAL.main()
    plane = json.loads((tmp_path / "ground_plane.json").read_text())
    expected = model.predict(path)
    assert plane["camera_height_m"] == pytest.approx(
        expected.ground_plane().camera_height_m, rel=0.01
    )
    assert plane["pitch_deg"] == pytest.approx(expected.ground_plane().pitch_deg, abs=0.2)
    depth_m = np.load(tmp_path / "ground_depth_m.npy")
    np.testing.assert_array_equal(np.isfinite(depth_m), expected.ground)
    np.testing.assert_allclose(depth_m, expected.ground_depth_m, rtol=0.01)


def test_the_minimal_program_gives_the_metres_of_the_vectors(vectors, minimal_outputs):
    checked = {f.quantity for f in check_vectors(vectors, minimal_outputs) if f.checked}
    assert {"ground_plane of the port's maps", "flat_ground_depth_m of the port's maps"} <= checked


JS = CHECKOUT / "runtime" / "js"
FILES = imported(JS / "tests" / "make_fixtures.py")


@pytest.mark.parametrize("name", FILES.LENSES)
def test_the_minimal_program_reads_a_file_s_lens(name, tmp_path, monkeypatch):
    """Crops, digital zoom and panoramas: the files that hold the package for JavaScript, too."""
    monkeypatch.setattr(FILES, "FIXTURES", tmp_path)
    lens = FILES.write_lens(name, **FILES.LENSES[name])
    with Image.open(tmp_path / f"lens-{name}.jpg") as photo:
        if lens["panorama"]:
            with pytest.raises(SystemExit, match="a panorama"):
                MINIMAL.focal_px(photo)
            return
        size = ImageOps.exif_transpose(photo).size[::-1]
        camera = fp.Intrinsics.assumed(size)
        if lens["focal35mm"] is not None:
            camera = fp.Intrinsics.from_focal_35mm(lens["focal35mm"], size)
        assert MINIMAL.focal_px(photo) == pytest.approx(camera.fx, rel=1e-9)


@pytest.mark.parametrize("place", stated(), ids=lambda place: f"{place.file}: {place.pattern}")
def test_what_is_stated_of_the_bundled_model_holds(place):
    """After another model, or a refit of its curves: make model-facts."""
    if not (CHECKOUT / place.file).is_file():
        pytest.skip(f"{place.file} is not in this checkout")
    assert states(place) == place.now


@pytest.fixture(scope="module")
def node_modules():
    """What the Node example has installed; the package for JavaScript is built then, too."""
    built = (JS / "dist").is_dir() and (EXAMPLES / "node" / "node_modules").is_dir()
    if not built or shutil.which("npm") is None:
        pytest.skip(
            "the Node example is not installed: make js && "
            "ONNXRUNTIME_NODE_INSTALL=skip npm ci --prefix examples/node"
        )

    return EXAMPLES / "node" / "node_modules"


@pytest.fixture(scope="module")
def node(node_modules):
    """The function that runs one of the programs for Node."""

    def start(script, *words):
        return run("npm", "run", "--silent", script, "--", *words, cwd=node_modules.parent)

    return start


def test_node_gives_the_vectors(node, model, vectors, tmp_path):
    node("vectors", model.path, vectors, tmp_path)
    assert differing(vectors, tmp_path) == []


def test_node_gives_a_painted_room(node, room, tmp_path):
    model, vectors = room
    node("vectors", model.path, vectors, tmp_path)
    assert differing(vectors, tmp_path) == []


def test_node_takes_pictures_and_prints_a_line_of_json_each(node, model, tmp_path):
    photo = tmp_path / "room.jpg"
    shutil.copyfile(ROOM, photo)
    turned = tmp_path / "turned.jpg"
    exif = Image.Exif()
    exif[0x112] = 6  # was held upright: to be turned by 90 degrees
    Image.open(ROOM).transpose(Image.Transpose.ROTATE_90).save(turned, quality=95, exif=exif)
    lines = node("find-ground", photo, turned).stdout.splitlines()
    for path, line in zip((photo, turned), lines, strict=True):
        found = json.loads(line)
        expected = model.predict(path)
        assert found["image"] == path.name
        assert tuple(found["image_size_px"]) == expected.image_size
        assert tuple(found["map_size_px"]) == expected.map_size
        focal = expected.intrinsics.scaled(expected.map_size, expected.image_size).focal_px
        assert found["camera"]["focal_length_px"] == pytest.approx(focal, rel=1e-6)
        assert found["camera"]["source"] == expected.intrinsics.source
        # JPEG decoders differ by a level or so, and int8 makes more of it.
        assert found["ground_fraction"]["all"] == pytest.approx(expected.ground.mean(), abs=0.03)
        plane = expected.ground_plane()
        assert found["ground_plane"]["camera_height_m"] == pytest.approx(
            plane.camera_height_m, rel=0.01
        )
        assert found["ground_plane"]["pitch_deg"] == pytest.approx(plane.pitch_deg, abs=0.5)
        distance_m = found["ground_distance_m"]["nearest"]
        assert distance_m == pytest.approx(np.nanmin(expected.ground_depth_m), rel=0.01)
        mask = np.asarray(Image.open(f"{path}.ground.png")) > 0
        assert mask.mean() == pytest.approx(found["ground_fraction"]["all"])


def test_node_goes_on_after_a_picture_that_is_none(node_modules, tmp_path):
    photo, broken = tmp_path / "room.jpg", tmp_path / "broken.jpg"
    shutil.copyfile(ROOM, photo)
    broken.write_bytes(b"\xff\xd8 no picture")
    words = ["npm", "run", "--silent", "find-ground", "--"]
    options = {"capture_output": True, "text": True, "cwd": node_modules.parent}
    done = subprocess.run([*words, broken, photo], check=False, **options)
    assert [json.loads(line)["image"] for line in done.stdout.splitlines()] == ["room.jpg"]
    assert done.returncode == 1
    (complaint,) = done.stderr.splitlines()
    assert "broken.jpg" in complaint
    done = subprocess.run([*words, "--camera-height", "high", photo], check=False, **options)
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (2, "", 1)


@pytest.fixture(scope="module")
def packed(node_modules, tmp_path_factory):
    """An empty folder, into which the package was installed from what `npm pack` makes."""
    folder = tmp_path_factory.mktemp("app")
    pack = ("npm", "pack", "--silent", "--ignore-scripts", "--pack-destination", folder)
    tarball = run(*pack, cwd=JS).stdout.split()[-1]
    (folder / "package.json").write_text('{"type": "module", "private": true}')
    run("npm", "install", "--offline", "--no-audit", "--no-fund", folder / tarball, cwd=folder)
    # The runtime beside it, as `npm install onnxruntime-node` puts it there.
    library = "onnxruntime-node"
    (folder / "node_modules" / library).symlink_to(node_modules / library)
    return folder


PROGRAM = """
import { readFileSync } from "node:fs";
import { load } from "footprints-edge";

const data = readFileSync("picture.rgb");
const model = await load();
const ground = await model.predict({ data, width: 1280, height: 720 }, { cameraHeightM: 1.4 });
const path: { lengthM: number } = ground.plan([640, 700], [640, 520]);
console.log(JSON.stringify({
  ground: ground.ground.reduce((sum, each) => sum + each, 0) / ground.ground.length,
  heightM: ground.groundPlane().cameraHeightM,
  rows: ground.topDown().rows,
  lengthM: path.lengthM,
}));
"""


def test_the_package_for_javascript_runs_where_it_is_installed(packed, model):
    pixels = np.asarray(Image.open(ROOM).convert("RGB"))
    (packed / "picture.rgb").write_bytes(pixels.tobytes())
    (packed / "program.mjs").write_text(PROGRAM.replace(": { lengthM: number }", ""))
    found = json.loads(run("node", "program.mjs", cwd=packed).stdout)
    expected = model.predict(pixels, camera_height_m=1.4)
    assert found["ground"] == pytest.approx(expected.ground.mean(), abs=1e-3)
    assert (found["heightM"], found["rows"]) == (pytest.approx(1.4), 200)
    length_m = expected.plan((640, 700), (640, 520)).length_m
    assert found["lengthM"] == pytest.approx(length_m, rel=0.01)
    assert not list((packed / "node_modules").glob("*/.gitignore"))
    licence = (packed / "node_modules" / "footprints-edge" / "LICENSE").read_text()
    assert licence == (CHECKOUT / "LICENSE").read_text()


WORKER = """
import { isMainThread, Worker } from "node:worker_threads";
import { load } from "footprints-edge";

if (isMainThread) {
  if (process.argv[2]) process.env.ORT_DISABLE_TELEMETRY = process.argv[2];
  new Worker(new URL(import.meta.url));
} else {
  const explained = ({ name, message }) => `${name}: ${message}`;
  console.log(await load().then((model) => model.metadata.name, explained));
}
"""


@pytest.mark.parametrize(("chosen", "says"), [("", "ModelError: a worker thread"), ("1", "edge")])
def test_a_worker_thread_of_node_reports_nothing(packed, tmp_path, chosen, says):
    (packed / "worker.mjs").write_text(WORKER)
    choices = {"CI", "TF_BUILD", "JENKINS_URL", "ORT_DISABLE_TELEMETRY", "XDG_CACHE_HOME"}
    kept = {name: value for name, value in os.environ.items() if name not in choices}
    words = ["node", packed / "worker.mjs", chosen]
    assert run(*words, cwd=packed, env=kept | {"HOME": str(tmp_path)}).stdout.startswith(says)
    assert list(tmp_path.iterdir()) == []


def test_the_package_for_javascript_has_types(packed):
    compiler = JS / "node_modules" / "typescript" / "bin" / "tsc"
    types = packed / "node_modules" / "@types"
    types.mkdir(exist_ok=True)
    (types / "node").symlink_to(JS / "node_modules" / "@types" / "node")
    options = {"module": "nodenext", "target": "es2022", "types": ["node"], "skipLibCheck": True}
    for name, program in (("right", PROGRAM), ("wrong", PROGRAM.replace("lengthM", "length_m"))):
        (packed / f"{name}.ts").write_text(program)
        settings = {"files": [f"{name}.ts"], "compilerOptions": {**options, "strict": True}}
        (packed / "tsconfig.json").write_text(json.dumps(settings))
        words = ["node", str(compiler), "--noEmit"]
        done = subprocess.run(words, check=False, capture_output=True, text=True, cwd=packed)
        assert (done.returncode == 0) == (name == "right"), done.stdout
