"""Many sentences are translated one by one, and what several bodies share is said once."""

import time
from types import ModuleType
from typing import Any

import pytest

NOTE = (
    '"{}": The edges of the mesh are 642 mm long, the fingertip 20 mm wide: subdivide the mesh or use a larger '
    "fingertip, for a visible dent."
)


@pytest.fixture
def japanese(bpy: ModuleType) -> Any:
    from bl_ext.user_default.dimple.addon.translations import JAPANESE

    return lambda text: JAPANESE.get(("*", text), text)


def test_what_several_bodies_share_is_said_once(bpy: ModuleType) -> None:
    from bl_ext.user_default.dimple.operators.messages import Note, gathered

    said = gathered([Note('"A": Fine.'), '"B": It leaks.', Note('"C": Fine.'), '"A": Fine.', "No name: none."])
    assert said == ["2 bodies: Fine.", '"B": It leaks.', '"A": Fine.', "No name: none."]
    assert [isinstance(each, Note) for each in said] == [True, False, False, False]


def test_sentences_of_many_bodies_are_translated_soon_and_like_one(bpy: ModuleType, japanese: Any) -> None:
    from bl_ext.user_default.dimple.operators import translation

    translation.translated(NOTE.format("Ball"), japanese)  # reads the catalogue
    began = time.process_time()
    row = translation.in_a_row([NOTE.format(f"Ball.{k:03}") for k in range(50)], japanese)
    joined = translation.translated(" ".join(NOTE.format(f"Ball.{k:03}") for k in range(50)), japanese)
    assert time.process_time() - began < 1.5
    assert row == joined == "".join(translation.translated(NOTE.format(f"Ball.{k:03}"), japanese) for k in range(50))
    assert "edges" not in row and row.count("642") == 50


def test_where_the_catalogue_is_not_in_the_language_a_message_is_not_looked_at(
    bpy: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import translation

    monkeypatch.setattr(translation, "_match", lambda _: pytest.fail("looked at"))
    assert translation.in_a_row(["One of 3.", "Two."], lambda text: text) == "One of 3. Two."
