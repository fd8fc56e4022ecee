"""Enabling and disabling leaves nothing behind, however often it is done."""

import subprocess
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import pytest

EXTENSION = "bl_ext.user_default.dimple"
TYPES = ("Panel", "Menu", "UIList", "Operator", "PropertyGroup", "AddonPreferences", "Gizmo", "GizmoGroup")
OWNERS = ("Object", "Material", "Scene", "WindowManager")


def ours(thing: Any) -> bool:
    return str(getattr(thing, "__module__", "")).startswith(EXTENSION)


def subclasses(base: type) -> Iterator[type]:
    for child in base.__subclasses__():
        yield child
        yield from subclasses(child)


def traces(bpy: ModuleType) -> set[str]:
    """Name everything in Blender that is Dimple's: classes, properties, handlers, keys, tools, menu entries."""
    from bl_ui.space_toolsystem_toolbar import VIEW3D_PT_tools_active

    found = set()
    for base in TYPES:
        registered = (c for c in subclasses(getattr(bpy.types, base)) if ours(c) and "bl_rna" in vars(c))
        found |= {f"{base} {c.__name__}" for c in registered}
    found |= {f"{owner}.dimple" for owner in OWNERS if hasattr(getattr(bpy.types, owner), "dimple")}
    for name in dir(bpy.app.handlers):
        functions = getattr(bpy.app.handlers, name)
        if isinstance(functions, list):
            found |= {f"{name} {function.__name__}" for function in functions if ours(function)}
    for keymap in bpy.context.window_manager.keyconfigs.addon.keymaps:
        found |= {f"key {item.idname}" for item in keymap.keymap_items if item.idname.startswith("dimple.")}
    for mode, tools in VIEW3D_PT_tools_active._tools.items():
        flat = [tool for group in tools for tool in (group if isinstance(group, tuple) else (group,))]
        found |= {f"tool {mode} {tool.idname}" for tool in flat if "dimple" in str(getattr(tool, "idname", ""))}
    for name in dir(bpy.types):
        entries = getattr(getattr(getattr(bpy.types, name), "draw", None), "_draw_funcs", ())
        found |= {f"{name} draws {function.__name__}" for function in entries if ours(function)}
    return found


@pytest.fixture
def live(bpy: ModuleType, monkeypatch: pytest.MonkeyPatch) -> set[object]:
    """What cannot be listed in Blender: the draw callbacks and timers added from here on and not removed."""
    held: set[object] = set()
    for name in dir(bpy.types):
        kind = getattr(bpy.types, name)
        if isinstance(kind, type) and bpy.types.Space in kind.__mro__[1:]:
            watch(monkeypatch, held, kind, "draw_handler_add", "draw_handler_remove")
    watch(monkeypatch, held, bpy.app.timers, "register", "unregister")
    return held


def watch(monkeypatch: pytest.MonkeyPatch, held: set[object], owner: Any, add: str, remove: str) -> None:
    add_it, remove_it = getattr(owner, add), getattr(owner, remove)

    def adding(first: object, *rest: Any, **options: Any) -> object:
        handle = add_it(first, *rest, **options)
        held.add(first if handle is None else handle)  # a timer is known by its function
        return handle

    def removing(handle: object, *rest: Any) -> None:
        remove_it(handle, *rest)
        held.discard(handle)

    monkeypatch.setattr(owner, add, adding)
    monkeypatch.setattr(owner, remove, removing)


def fail(error: Exception) -> None:
    raise error


def test_ten_times_on_and_off_leaves_nothing_behind(
    bpy: ModuleType, live: set[object], capfd: pytest.CaptureFixture[str]
) -> None:
    import addon_utils

    installed = traces(bpy)
    assert {"Operator DIMPLE_OT_poke", "Object.dimple", "Material.dimple", "Scene.dimple"} <= installed
    addon_utils.disable(EXTENSION, default_set=True, handle_error=fail)
    for _ in range(10):
        assert (traces(bpy), live) == (set(), set())
        addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)
        assert traces(bpy) == installed
        addon_utils.disable(EXTENSION, default_set=True, handle_error=fail)
    addon_utils.enable(EXTENSION, default_set=True, handle_error=fail)
    printed = "".join(capfd.readouterr())
    assert [line for line in printed.splitlines() if any(w in line for w in ("Error", "Warning", "Traceback"))] == []


def test_enabling_imports_nothing_heavy(bpy: ModuleType) -> None:
    """Start-up is quick: what computes is imported at the first press."""
    lines = (
        "import sys, bpy, addon_utils",  # bpy brings numpy; Blender itself may not
        "for name in ('ctypes', 'numpy', 'scipy', 'serial', 'trimesh'):",
        "    sys.modules[name] = None",
        f"assert addon_utils.enable('{EXTENSION}') is not None",
    )
    answer = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, timeout=120)
    assert answer.returncode == 0, answer.stdout + answer.stderr
