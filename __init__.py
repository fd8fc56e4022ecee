"""Dimple, a Blender extension: press soft meshes with a fingertip.

Nothing is imported here until Blender registers the extension, so that tests and tools can import
`core` from this folder without Blender.
"""


def register() -> None:
    from . import addon

    addon.register()


def unregister() -> None:
    from . import addon

    addon.unregister()
