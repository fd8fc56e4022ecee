"""What a hand does with Blender's own interface in the window test: search, type into a field, drag it, open a panel.

Fields are found by hovering: Blender's own "Copy Data Path" knows which property is under the mouse. Theme, language,
font and order do not matter then.
"""

from __future__ import annotations

from collections.abc import Callable, Generator

import bpy
import device
import robot

Place = tuple[int, int]
Found = Generator[float, None, Place]
DIGITS = dict(zip("0123456789.", ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE",
                                  "PERIOD"), strict=True))  # fmt: skip
DOWN, ALONG = 16, 24  # [px] between two places that are hovered: a field is 20 high, one in a header 60 wide or more
MODES = 106  # [px] from the left edge of a viewport's header to the middle of its menu of modes
SIDE_TAB = 10  # [px] from the right edge of the sidebar to the middle of its tabs
FAR = 60  # notches of the wheel: past the end of any sidebar


def strike(kind: str, at: Place, **more: object) -> robot.Waits:
    """Strike a key, with ctrl, shift, alt or the character that it writes."""
    window = robot.window()
    window.event_simulate(type=kind, value="PRESS", x=round(at[0]), y=round(at[1]), **more)
    yield robot.TICK_S
    more.pop("unicode", None)
    window.event_simulate(type=kind, value="RELEASE", x=round(at[0]), y=round(at[1]), **more)
    yield robot.TICK_S


def write(text: str, at: Place) -> robot.Waits:
    """Type a text, letters, digits, points and spaces."""
    for letter in text:
        kind = DIGITS.get(letter) or ("SPACE" if letter == " " else letter.upper())
        yield from strike(kind, at, unicode=letter, **({"shift": True} if letter.isupper() else {}))


def search(words: str, at: Place) -> robot.Waits:
    """Look for an operator with F3 and start it with Enter."""
    yield from robot.move(*at)
    yield from strike("F3", at)
    yield from robot.looks(6)
    yield from write(words, at)
    yield from robot.looks(10)
    yield from strike("RET", at)
    yield from robot.looks(4)


def hovered(area: bpy.types.Area, region: bpy.types.Region) -> str:
    """Return the data path of the property under the mouse, "" where there is none."""
    with bpy.context.temp_override(window=robot.window(), area=area, region=region):
        if not bpy.ops.ui.copy_data_path_button.poll():
            return ""
        bpy.ops.ui.copy_data_path_button(full_path=True)
    return bpy.context.window_manager.clipboard


def fields(
    area: bpy.types.Area, region: bpy.types.Region, *wanted: str, upwards: bool = False
) -> Generator[float, None, dict[str, Place]]:
    """Hover over a region, a header from left to right, another down its right half, and return where fields are.

    Args:
        wanted: ends of data paths; stop when all are found.
        upwards: begin at its lower end.

    Returns:
        The middle of each field, or of all buttons of one property; its ends are arrows that change it.
    """
    found: dict[str, list[Place]] = {}
    if region.height < 60:
        y = region.y + region.height // 2
        places = [(x, y) for x in range(region.x + 4, region.x + region.width, ALONG)]
    else:
        x = region.x + round(0.72 * (region.width - 2 * SIDE_TAB))
        places = [(x, y) for y in range(region.y + region.height - 4, region.y, -DOWN)]
    for place in reversed(places) if upwards else places:
        yield from robot.move(*place)
        name = hovered(area, region).rpartition(".")[2]
        if wanted and name not in wanted and all(each in found for each in wanted):
            break  # the last of its buttons lies behind
        if name:
            found.setdefault(name, []).append(place)
    return {name: each[len(each) // 2] for name, each in found.items()}


def header_of(area: bpy.types.Area, kind: str = "TOOL_HEADER") -> bpy.types.Region:
    return next(each for each in area.regions if each.type == kind)


def in_header(name: str) -> Found:
    """Return where a field of the tool's settings is."""
    found = yield from fields(robot.area(), header_of(robot.area()), name)
    if name not in found:
        raise robot.NotReached(f"the tool's header has no {name}; there are {sorted(found)}")
    return found[name]


def button(name: str) -> Found:
    """Return where the button of an operator of ours is in the sidebar, found by hovering."""
    wanted = f"bpy.ops.dimple.{name}("
    found = yield from robot.find_buttons(wanted)
    place = next((at for command, at in found.items() if command.startswith(wanted)), None)
    if place is None:
        raise robot.NotReached(f"no button of the sidebar calls dimple.{name}; there are {sorted(found)}")
    return place


def in_sidebar(name: str) -> Found:
    """Return where a field of the sidebar is, turning the wheel until it is seen."""
    found: dict[str, Place] = {}
    for notches in (0, 8, 8, 8):
        yield from wheel(notches)
        found = yield from fields(robot.area(), robot.region("UI"), name)
        while name in found:
            yield from robot.move(*found[name])
            yield from robot.looks(4)
            if hovered(robot.area(), robot.region("UI")).endswith(f".{name}"):
                return found[name]
            found = yield from fields(robot.area(), robot.region("UI"), name)  # a panel has opened above it meanwhile
    raise robot.NotReached(f"the sidebar shows no {name}; there are {sorted(found)}")


def constant(name: str) -> Found:
    """Return where a constant of the material is: its panel is closed, and drawn open once more."""
    device.open_panel("DIMPLE_PT_object_constants", "Dimple")
    return (yield from in_sidebar(name))


def wheel(notches: int, kind: str = "WHEELDOWNMOUSE") -> robot.Waits:
    """Turn the wheel over the sidebar, and wait until that has been scrolled."""
    sidebar = robot.region("UI")
    at = sidebar.x + 12, sidebar.y + sidebar.height // 2
    yield from robot.move(*at)
    for _ in range(notches):  # at once: a picture after each takes minutes in software
        robot.window().event_simulate(type=kind, value="PRESS", x=at[0], y=at[1])
    yield from robot.redrawn()
    before = None
    while before != (now := tuple(sidebar.view2d.region_to_view(0, 0))):
        before = now
        yield from robot.redrawn(1)


def type_into(at: Place, number: float) -> robot.Waits:
    """Type a number into the field that is hovered: Enter opens it, Enter closes it."""
    yield from robot.move(*at)
    yield from robot.move(at[0] + 1, at[1])
    yield from strike("RET", at)
    yield from robot.looks(2)
    yield from strike("A", at, ctrl=True)
    yield from write(f"{number:g}", at)
    yield from strike("RET", at)
    yield from robot.looks(2)


def drag(at: Place, until: Callable[[], bool], step: int = 6, limit: int = 60) -> robot.Waits:
    """Press on a field, draw the mouse to the right in steps until it is far enough, and let go.

    Raises:
        NotReached: the value did not get there.
    """
    yield from robot.move(*at)
    yield from robot.button(*at, "PRESS")
    x = at[0]
    for _ in range(limit):
        if until():
            break
        x += step
        yield from robot.move(x, at[1])
    yield from robot.button(x, at[1], "RELEASE")
    if not until():
        raise robot.NotReached("the value that was dragged did not get so far")


def open_tab(name: str, at: Place) -> robot.Waits:
    """Open the sidebar with N over the viewport and click down its tabs until the wanted one is open."""
    yield from robot.move(*at)
    if not robot.area().spaces.active.show_region_ui:
        yield from strike("N", at)
    yield from robot.redrawn()
    sidebar = robot.region("UI")
    yield from robot.until(lambda: sidebar.width > 1 and sidebar.active_panel_category != "UNSUPPORTED", "N opens it")
    for y in range(sidebar.y + sidebar.height - 20, sidebar.y, -20):
        if sidebar.active_panel_category == name:
            return
        yield from robot.click(sidebar.x + sidebar.width - SIDE_TAB, y)
        yield from robot.looks(2)
    if sidebar.active_panel_category != name:
        raise robot.NotReached(f"no tab of the sidebar is {name}")


def open_last_panel(field: str) -> Found:
    """Turn the wheel to the end of the sidebar and click the last panel's header; return where its field is."""
    yield from wheel(FAR)
    sidebar = robot.region("UI")
    yield from robot.looks(4)
    found = yield from fields(robot.area(), sidebar, field, upwards=True)
    for y in range(sidebar.y + 8, sidebar.y + 60, DOWN // 2):
        if field in found:
            break
        yield from robot.click(sidebar.x + 60, y)
        yield from robot.looks(10)
        yield from wheel(FAR)
        found = yield from fields(robot.area(), sidebar, field, upwards=True)
    if field not in found:
        raise robot.NotReached(f"the last panel has no {field}; there are {sorted(found)}")
    return found[field]


def choose(field: str, chosen: Callable[[], bool], limit: int = 12) -> robot.Waits:
    """Turn the wheel with Ctrl over a menu's field in the last panel until it shows the wanted item: down, then up.

    Raises:
        NotReached: it shows that nowhere.
    """
    at: Place | None = None
    for kind in ("WHEELDOWNMOUSE", "WHEELUPMOUSE"):
        for _ in range(limit):
            if chosen():
                return
            while not at or not hovered(robot.area(), robot.region("UI")).endswith(f".{field}"):
                # it moves where the readout above it grows
                at = yield from open_last_panel(field)
                yield from robot.move(*at)
                yield from robot.move(at[0] + 1, at[1])
            robot.window().event_simulate(type=kind, value="PRESS", x=at[0], y=at[1], ctrl=True)
            yield robot.TICK_S
    if not chosen():
        raise robot.NotReached("the field has no such item")


def mode(letter: str, wanted: str) -> robot.Waits:
    """Open the menu of modes in the header and choose by the letter that is underlined; a poke goes on meanwhile."""
    header = header_of(robot.area(), "HEADER")
    at = header.x + MODES, header.y + header.height // 2
    yield from robot.click(*at)
    yield from robot.looks(8)
    yield from strike(letter, at)
    yield from robot.until(lambda: bpy.context.mode == wanted, f"the menu leads to {wanted}", 10)
    yield from robot.redrawn()


def brush(weight: float, size: int) -> robot.Waits:
    """Type weight, strength and size of the brush into the tool's header."""
    for name, value in (("weight", weight), ("strength", 1.0), ("size", size)):
        yield from type_into((yield from in_header(name)), value)
