"""Who may import whom, read off the sources: nothing is imported to find out."""

import ast
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[1]
PACKAGES = {
    "footprints_edge": CHECKOUT / "runtime",
    "footprints_edge_export": CHECKOUT / "export",
    "footprints_edge_models": CHECKOUT / "models",
    "footprints_edge_bench": CHECKOUT / "bench",
}

ORDER = {
    "footprints_edge": (
        "errors",
        "foundation",
        "parallel",
        "geometry",
        "inputs",
        "model_files",
        "engines",
        "maps",
        "navigation",
        "drawing",
        "outputs",
        "video",
        "ros",
        "prediction",
        "model",
        "__init__",
        "cli",
        "__main__",
    ),
    "footprints_edge_models": (
        "__init__",
        "sample",
        "bounded_files",
        "segmenter",
        "networks",
        "mapping",
        "sequences",
        "video_labels",
        "asset_files",
        "panoramas",
        "scenes",
        "insertion",
        "data",
        "training",
        "cli",
    ),
    "footprints_edge_export": (
        "__init__",
        "errors",
        "targets",
        "credits_section",
        "partial_networks",
        "architectures",
        "graph",
        "passes",
        "quantization",
        "verification",
        "report",
        "job",
        "artifact",
        "convert",
        "bundle",
        "cli",
    ),
    "footprints_edge_bench": (
        "__init__",
        "foundation",
        "geometry",
        "ground_truth",
        "accuracy",
        "navigation",
        "temporal",
        "model_files",
        "engines",
        "peers",
        "latency",
        "passes",
        "cli",
    ),
}
"""The parts of each package, lowest first: each imports only itself and what stands before it."""


def files(package):
    found = sorted((PACKAGES[package] / package).rglob("*.py"))
    assert found, f"no sources of {package} found"
    return found


def module_name(path, package):
    parts = path.relative_to(PACKAGES[package]).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(statement, path, package):
    """Full names of the modules that one import statement asks for, or may ask for."""
    if isinstance(statement, ast.Import):
        return [alias.name for alias in statement.names]
    base = statement.module or ""
    if statement.level:
        folder = path.parent.relative_to(PACKAGES[package]).parts
        folder = folder[: len(folder) - statement.level + 1]
        base = ".".join([*folder, *filter(None, [statement.module])])
    return [base, *(f"{base}.{alias.name}" for alias in statement.names)]


def is_type_checking(node):
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)


def statements(node):
    """Import statements that run when a module is imported, as (statement, False); those that
    run later, inside functions, or never, for types only, as (statement, True)."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child, False
        else:
            later = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            later = later or is_type_checking(child)
            for statement, inner in statements(child):
                yield statement, inner or later


def imports(package, *, at_import_only=False):
    """(path, module) of every import of a package's sources."""
    for path in files(package):
        for statement, later in statements(ast.parse(path.read_text(encoding="utf-8"))):
            if not (at_import_only and later):
                for name in imported(statement, path, package):
                    yield path, name


def offenders(package, forbidden, **options):
    return sorted(
        f"{path.relative_to(CHECKOUT)} imports {name}"
        for path, name in imports(package, **options)
        if name.split(".")[0] in forbidden
    )


def test_the_sources_are_found_and_their_imports_read():
    names = {name for _, name in imports("footprints_edge")}
    assert {"numpy", "onnxruntime", "footprints_edge.errors"} <= names
    names = {name for _, name in imports("footprints_edge_models")}
    assert {
        "torch",
        "footprints_edge_models.training.losses",
        "footprints_edge.geometry.camera",
    } <= names
    later = {name for _, name in imports("footprints_edge_bench")} - {
        name for _, name in imports("footprints_edge_bench", at_import_only=True)
    }
    assert "torch" in later


def test_the_runtime_imports_none_of_the_others_nor_what_they_need():
    forbidden = {*PACKAGES, "torch", "onnx", "onnx_ir", "onnxscript", "matplotlib", "tqdm"}
    assert offenders("footprints_edge", forbidden - {"footprints_edge"}) == []


@pytest.mark.parametrize(
    ("library", "file"),
    [
        ("onnxruntime", "engines/onnxruntime_engine"),
        ("av", "video/encoders"),
        ("cv2", "foundation/opencv"),
        ("ray", "parallel/on_ray"),
    ],
)
def test_one_file_of_the_runtime_knows_each_large_library(library, file):
    users = {
        path.relative_to(PACKAGES["footprints_edge"]).as_posix()
        for path, name in imports("footprints_edge")
        if name.split(".")[0] == library
    }
    assert users == {f"footprints_edge/{file}.py"}


def test_opencv_is_imported_where_it_is_used():
    assert offenders("footprints_edge", {"cv2"}, at_import_only=True) == []


def test_models_import_neither_export_nor_bench():
    forbidden = {
        "footprints_edge_export",
        "footprints_edge_bench",
        "onnx",
        "onnx_ir",
        "onnxruntime",
    }
    assert offenders("footprints_edge_models", forbidden) == []


def test_export_imports_the_runtime_and_models_only():
    assert offenders("footprints_edge_export", {"footprints_edge_bench"}) == []


def test_bench_imports_what_is_heavy_where_it_is_used():
    heavy = {"footprints_edge_models", "footprints_edge_export", "torch", "onnx", "onnx_ir"}
    assert offenders("footprints_edge_bench", heavy, at_import_only=True) == []


def cycle(graph):
    """One cycle of a graph of names, or None."""
    done, trail = set(), []

    def visit(name):
        if name in trail:
            return [*trail[trail.index(name) :], name]
        if name in done:
            return None
        trail.append(name)
        for neighbour in sorted(graph.get(name, ())):
            if found := visit(neighbour):
                return found
        trail.pop()
        done.add(name)
        return None

    return next(filter(None, map(visit, sorted(graph))), None)


def test_a_cycle_would_be_found():
    assert cycle({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == ["a", "b", "c", "a"]
    assert cycle({"a": {"b", "c"}, "b": {"c"}, "c": set()}) is None


def part_of(module, package):
    """The folder, or the file at the top, that a module belongs to."""
    below = module.removeprefix(package).lstrip(".")
    return below.split(".")[0] or "__init__"


def climbs(package):
    """Imports of a lower part from a higher one, those inside functions and for types included."""
    rank = {part: place for place, part in enumerate(ORDER[package])}
    for path, name in imports(package):
        if name.split(".")[0] != package or name == package:
            continue
        this, other = (part_of(each, package) for each in (module_name(path, package), name))
        if other in rank and rank[other] > rank[this]:
            yield f"{path.relative_to(CHECKOUT)} imports {name}"


@pytest.mark.parametrize("package", ORDER)
def test_the_order_names_every_folder_and_file_at_the_top(package):
    root = PACKAGES[package] / package
    parts = {path.stem for path in root.glob("*.py")}
    parts |= {path.name for path in root.iterdir() if (path / "__init__.py").is_file()}
    assert parts == set(ORDER[package])


@pytest.mark.parametrize("package", ORDER)
def test_no_part_imports_a_higher_one(package):
    assert sorted(climbs(package)) == []


@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_imports_itself_in_a_circle(package):
    """Imports inside functions count: they are arrows of the architecture as well."""
    modules = {module_name(path, package) for path in files(package)}
    graph = {name: set() for name in modules}
    for path, name in imports(package):
        this = module_name(path, package)
        # `import a.b` and `from a import b` run a's __init__ too; that of the package itself
        # has begun before any of its modules does.
        if name in modules and name not in {this, package}:
            graph[this].add(name)
    assert cycle(graph) is None


@pytest.mark.parametrize("package", PACKAGES)
def test_library_code_prints_nothing(package):
    printing = [
        f"{path.relative_to(CHECKOUT)}:{node.lineno}"
        for path in files(package)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in {"print", "breakpoint"}
    ]
    assert printing == []


@pytest.mark.parametrize("package", PACKAGES)
def test_each_package_says_that_it_is_typed(package):
    assert (PACKAGES[package] / package / "py.typed").is_file()
