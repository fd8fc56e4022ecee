"""What the tests of exports share with those of the operators."""

from tests.blender.operators.conftest import add, ball, coordinates, pressed, scene, shown

__all__ = ["add", "ball", "coordinates", "pressed", "scene", "shown"]
