"""What several bodies share is said once, and a recorded message is read in the language of the one who reads it."""

from types import ModuleType


def test_what_several_bodies_share_is_said_once(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.core.message import about
    from bl_ext.user_default.dimple.operators.reporting import Note, gathered

    fine = Note("Fine.")
    leaks, other = about("B", "It leaks."), about("A", "Fine.")
    said = gathered([about("A", fine), leaks, about("C", fine), other, "No name: none."])
    assert said == ["2 bodies: Fine.", '"B": It leaks.', '"A": Fine.', "No name: none."]
    assert [isinstance(each, Note) for each in said] == [True, False, False, False]


def test_what_is_shared_is_translated_with_its_values(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.addon.translations import dictionaries
    from bl_ext.user_default.dimple.core.message import Message, about
    from bl_ext.user_default.dimple.operators.reporting import duration, gathered
    from bl_ext.user_default.dimple.operators.translation import translated

    japanese = dictionaries()["ja_JP"]

    def lookup(text: str) -> str:
        return japanese.get(("*", text), text)

    holes = Message("Holes closed for the pressure only: {holes}.", holes=2)
    (said,) = gathered([about("A", holes), about("B", holes)])
    assert translated(said, lookup) == "2 個の物体: 圧力の計算でのみふさぐ穴: 2 個。"
    assert [translated(duration(each), lookup) for each in (0, 5, 65, 7800)] == [
        "1 秒未満", "5 秒", "1 分 5 秒", "2 時間 10 分",
    ]  # fmt: skip
