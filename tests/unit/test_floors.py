"""The floors of the house: who may import whom, read from the sources without running them."""

import ast
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from tools.environment import ROOT, WHEEL_PINS

# a module imports its own floor and those below; one missing here fails a test
FLOORS = {
    "addon": 12,
    "operators": 11,
    "operators.body": 10,
    "operators.export": 9,
    "operators.device": 9,
    "operators.experiment": 9,
    "operators.animate": 8,
    "operators.calibrate": 8,
    "operators.press": 7,
    "operators.bug_report": 7,
    "operators.bridge": 6,
    "operators.reporting": 5,
    "operators.names": 5,
    "operators.translation": 5,
    "core.calibration": 4,
    "core.experiment": 4,
    "core.device": 4,
    "core.fields": 4,
    "core.session": 3,
    "core.world": 3,
    "core.poke": 3,
    "core.recording": 3,
    "core.reduction": 3,
    "core.native": 2,
    "core.body": 1,
    "core.mesh": 1,
    "core.base": 0,
    "core.constants": 0,
    "core.errors": 0,
    "core.fills": 0,
    "core.message": 0,
    "core.background_work": 0,
    "core.file_lock": 0,
    "core.vectors": 0,
    "core.material": 0,
    "core.everyday_presets": 1,
    "core.other_tip": 1,
}
BLENDER = set("addon_utils bl_ext bl_operators bl_ui blf bmesh bpy bpy_extras gpu gpu_extras mathutils pxr".split())
ONLY_IN = {"ctypes": "core/native/", "serial": "core/device/serial_line.py"}
REFUSED = {"threading", "multiprocessing", "_thread"}  # Blender's reviewers refuse threads
BESIDE = {"blend_samples", "dev", "studies", "tests", "tools"}
ENTRIES = {
    "addon",
    "operators.body",  # the front door for scripts, at the root
    "core.device.start", "core.device.servo_process",  # start.py names it in a string
}  # fmt: skip


def sources() -> Iterator[Path]:
    for folder in ("addon", "operators", "core"):
        yield from sorted((ROOT / folder).rglob("*.py"))


@cache
def imports(path: Path) -> tuple[tuple[str, int], ...]:
    """Return the dotted name of everything a file imports, from the root of the project, and its line.

    A name that is not of this project starts as it is written; a relative one starts with addon, operators or
    core; one that is absolute although it is of this project starts with "absolute".
    """
    package, found = path.relative_to(ROOT).parent.parts, []
    for node in ast.walk(ast.parse(path.read_text(), str(path))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else ()
            base = [*above, *([node.module] if node.module else [])]
            names = [".".join([*base, alias.name]) for alias in node.names]
        else:
            continue
        relative = isinstance(node, ast.ImportFrom) and node.level > 0
        for name in names:
            own = name.partition(".")[0] in ("addon", "operators", "core")
            found.append((f"absolute.{name}" if own and not relative else name, node.lineno))
    return tuple(found)


def module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def import_graph() -> dict[str, set[str]]:
    """Return the modules of the project that each module imports, inside functions too; a package is its __init__."""
    modules = {module(path): path for path in sources()}
    graph: dict[str, set[str]] = {}
    for here, path in modules.items():
        named = {name if name in modules else name.rpartition(".")[0] for name, _ in imports(path)}
        graph[here] = {name for name in named if name in modules and name != here}
    return graph


def circles(graph: Mapping[str, set[str]]) -> list[tuple[str, ...]]:
    """Return circles of imports until none is left, each sorted; of those that overlap only some are named."""
    left, found = {name: set(below) for name, below in graph.items()}, []
    while True:
        try:
            TopologicalSorter(left).prepare()
        except CycleError as error:
            circle = error.args[1]  # each module is imported by the next one; the last is the first again
            found.append(tuple(sorted(set(circle))))
            left[circle[1]].discard(circle[0])
        else:
            return sorted(found)


def floor(dotted: str) -> int | None:
    """Return the floor of a module of the project, None for others and for `core` itself."""
    parts = dotted.split(".")
    return FLOORS.get(".".join(parts[:2]), FLOORS.get(parts[0]))


def wrong(paths: Iterable[Path], is_wrong: Callable[[Path, str], bool]) -> list[str]:
    """Return where files import what they may not."""
    return [
        f"{path.relative_to(ROOT)}:{line} imports {name}"
        for path in paths for name, line in imports(path) if is_wrong(path, name)
    ]  # fmt: skip


def test_every_module_stands_on_a_floor() -> None:
    root = ROOT / "core" / "__init__.py"
    assert [str(path) for path in sources() if path != root and floor(module(path)) is None] == []


def test_imports_go_down_only() -> None:
    def goes_up(path: Path, name: str) -> bool:
        here, there = floor(module(path)), floor(name)
        return here is not None and there is not None and there > here

    assert wrong(sources(), goes_up) == []


def test_no_modules_import_each_other_in_a_circle() -> None:
    assert circles(import_graph()) == []


def test_every_module_that_ships_can_be_reached() -> None:
    """What neither Blender's registration nor the process of a device leads to belongs to studies/ or tests/."""
    graph, reached, ahead = import_graph(), set(), set(ENTRIES)
    while ahead:
        name = ahead.pop()
        reached.add(name)
        packages = {name[:end] for end, letter in enumerate(name) if letter == "."}
        ahead |= (graph[name] | packages) - reached
    assert sorted(set(graph) - reached) == []


def test_the_laboratory_is_imported_by_nothing_that_ships() -> None:
    shipped = [ROOT / "__init__.py", *sources()]
    assert wrong(shipped, lambda _, name: name.partition(".")[0] in BESIDE) == []


def test_the_project_imports_itself_by_relative_names() -> None:
    """Inside Blender the extension is bl_ext.<repository>.dimple, so `import core` finds nothing."""
    assert wrong(sources(), lambda _, name: name.startswith("absolute.")) == []


def test_core_knows_nothing_of_blender() -> None:
    assert wrong((ROOT / "core").rglob("*.py"), lambda _, name: name.partition(".")[0] in BLENDER) == []


def test_native_code_serial_ports_and_threads_stay_in_their_places() -> None:
    def is_misplaced(path: Path, name: str) -> bool:
        top = name.partition(".")[0]
        return top in REFUSED or not str(path.relative_to(ROOT)).startswith(ONLY_IN.get(top, ""))

    assert wrong(sources(), is_misplaced) == []


def test_the_zip_ships_every_package_the_extension_imports_and_no_other() -> None:
    """Blender brings the standard library and numpy; the rest is a wheel in the manifest."""
    known = {*sys.stdlib_module_names, *BLENDER, "numpy", "addon", "operators", "core", "absolute"}
    used = {name.partition(".")[0] for path in sources() for name, _ in imports(path)} - known
    pinned = {line.partition("==")[0] for line in WHEEL_PINS.read_text().splitlines() if "==" in line}
    assert used == {"serial" if name == "pyserial" else name for name in pinned}


def test_the_root_imports_nothing_until_it_is_registered() -> None:
    tree = ast.parse((ROOT / "__init__.py").read_text())
    assert [node.lineno for node in tree.body if isinstance(node, (ast.Import, ast.ImportFrom))] == []


def test_no_package_marker_stands_under_tests() -> None:
    """An __init__.py there shadows the packages of the same name."""
    assert list((ROOT / "tests").rglob("__init__.py")) == []
