"""The architecture of the design page: layers, who may import which library, sizes, names."""

import ast
import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.conftest import SLOWEST, TESTS

RECON = Path(__file__).parents[1] / "recon"

LAYERS = {
    "errors": 0, "version": 0,
    "geometry": 1, "libraries": 1, "files": 1, "plugins": 1, "notices": 1, "locks": 1, "threads": 1,
    "processes": 2,
    "settings": 2, "camera": 2, "stopwatch": 2, "environment": 2,
    "records": 3, "manifest": 3,
    "world": 4, "stereo": 4, "voxelmap": 4, "recognition": 4, "runfolder": 4,
    "mapping": 5, "surface": 5, "sequences": 5, "exports": 5, "figures": 5,
    "localisation": 6,
    "exploration": 7,
    "runs": 8,
    "batch": 9, "app": 9,
    "cli": 10,
}  # fmt: skip

HOMES = {
    "open3d": {"world", "voxelmap", "recognition", "surface", "localisation", "exports"},
    "cv2": {"stereo", "sequences", "localisation", "world", "exports", "figures"},
    "skimage": {"sequences"},
    "PIL": {"world", "sequences", "figures"},
    "pyvista": {"figures", "app", "exports", "voxelmap"},  # VoxelMap.to_pyvista
    "matplotlib": {"figures"},
    "nicegui": {"app"},
    "dask": {"batch"},
    "distributed": {"batch"},
    "numba": {
        "stereo",
        "world",
        "voxelmap",
        "recognition",
        "mapping",
        "surface",
        "localisation",
        "exploration",
    },
    "rosbags": {"sequences"},
    "pypcd4": {"exports"},
    "laspy": {"exports"},
    "pye57": {"exports"},
    "trimesh": {"exports"},
    "pyoctomap": {"exports"},
    "pyarrow": {"exports", "batch"},
    "zarr": {"exports", "batch"},
    "fsspec": {"exports", "batch"},
}

# A call of these functions counts as the import it makes.
LAZY_IMPORTS = {"load_open3d": "open3d", "load_pyvista": "pyvista"}


def package_of(path: Path) -> str:
    """Name the package of a file."""
    first = path.relative_to(RECON).parts[0]
    return first.removesuffix(".py")


def imports(source: str) -> Iterator[str]:
    """Yield every module that a source imports, at the top, inside functions or lazily."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
            if node.module == "recon":
                yield from (f"recon.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id in LAZY_IMPORTS:
                yield LAZY_IMPORTS[node.func.id]
            if node.func.id == "load_extra" and isinstance(node.args[0], ast.Constant):
                yield str(node.args[0].value)


def faults(package: str, source: str) -> list[str]:
    """List the imports of a source that violate the design."""
    found = []
    for module in imports(source):
        parts = module.split(".")
        if parts[0] == "recon" and len(parts) > 1:
            other = parts[1]
            if other != package and LAYERS[other] >= LAYERS[package]:
                found.append(
                    f"{package} (layer {LAYERS[package]}) imports {other} ({LAYERS[other]})"
                )
        elif parts[0] in HOMES and package not in HOMES[parts[0]] and package != "libraries":
            found.append(f"{parts[0]} is imported in {package}")
    return found


def sources() -> list[Path]:
    return [
        path
        for path in sorted(RECON.rglob("*.py"))
        if path.parent != RECON or path.stem != "__init__"
    ]


@pytest.mark.parametrize("path", sources(), ids=lambda path: str(path.relative_to(RECON)))
def test_imports_go_strictly_downwards_and_libraries_stay_in_their_packages(path):
    assert faults(package_of(path), path.read_text()) == []


@pytest.mark.parametrize(
    ("package", "source"),
    [
        ("stereo", "from recon.voxelmap import VoxelMap"),
        ("camera", "import recon.records"),
        ("records", "def f():\n    from recon.mapping.pair import process_pair"),
        ("stereo", "from recon import runs"),
        ("stereo", "import matplotlib.pyplot"),
        ("figures", "from recon.libraries import load_open3d\no3d = load_open3d()"),
        ("cli", "laspy = load_extra('laspy', 'las')"),
    ],
)
def test_the_layout_test_fires(package, source):
    assert len(faults(package, source)) == 1


def test_every_package_has_a_layer():
    packages = {package_of(path) for path in sources()}
    assert packages <= set(LAYERS), f"packages without a layer: {packages - set(LAYERS)}"


def test_no_file_is_over_300_lines():
    files = [*sources(), *TESTS.rglob("*.py"), *(TESTS.parent / "tools").rglob("*.py")]
    long = {str(p): n for p in files if (n := len(p.read_text().splitlines())) > 300}
    assert long == {}


def test_no_module_has_a_meaningless_name():
    nouns = {part for path in RECON.rglob("*") for part in [path.stem.lower()]}
    assert not nouns & {"utils", "util", "common", "helpers", "helper", "tools", "misc"}


def module_of(path: Path) -> str:
    """Give the dotted name of a file; that of the package for an `__init__`."""
    parts = path.relative_to(RECON.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def first_imports(source: str, known: set[str]) -> set[str]:
    """List the modules of recon that a source imports at import time."""
    found = set()
    for node in ast.parse(source).body:
        if isinstance(node, ast.ImportFrom) and node.module:
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in known else node.module for name in names}
    return found & known


def graph() -> dict[str, set[str]]:
    """Map every module to the modules it imports."""
    files = {module_of(path): path for path in RECON.rglob("*.py")}
    return {
        name: first_imports(path.read_text(), set(files)) - {name} for name, path in files.items()
    }


def subpackages(modules: dict[str, set[str]]) -> dict[str, set[str]]:
    """Reduce the graph to subpackages and the files beside them."""
    packages: dict[str, set[str]] = {}
    for module, others in modules.items():
        package = ".".join(module.split(".")[:3])
        inner = {".".join(other.split(".")[:3]) for other in others}
        packages.setdefault(package, set()).update(inner - {package})
    return packages


def cycle(imports_of: dict[str, set[str]]) -> list[str]:
    """Find a cycle, if there is one."""
    try:
        TopologicalSorter(imports_of).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_module_or_subpackage_is_in_an_import_cycle():
    assert cycle(graph()) == []
    assert cycle(subpackages(graph())) == []


def test_import_cycle_is_detected():
    modules = {"recon.a.b.x": {"recon.a.c.y"}, "recon.a.c.y": set(), "recon.a.c.z": {"recon.a.b.x"}}
    assert cycle(modules) == []
    assert len(cycle(subpackages(modules))) > 1


def test_the_design_page_shows_every_package_on_its_layer():
    page = (RECON.parent / "docs" / "design.md").read_text()
    rows = re.findall(r"^\| (\d+) \| (.*?) \|", page, re.M)
    shown = {
        package: int(layer)
        for layer, packages in rows
        for package in re.findall(r"`(\w+)/?`", packages)
    }
    assert shown == LAYERS


def test_listed_slow_test_files_exist():
    assert [name for name in SLOWEST if not (TESTS / name).is_file()] == []
