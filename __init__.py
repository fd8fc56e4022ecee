"""Dimple, a Blender extension: press soft meshes with a fingertip.

`Body` is the front door for scripts. Nothing is imported here until Blender registers the extension or a script asks
for it, so that tests and tools can import `core` from this folder without Blender.
"""


def __getattr__(name: str) -> object:
    if name == "Body":
        from .operators.body import Body

        return Body
    if name == "DimpleError":
        from .core.errors import DimpleError

        return DimpleError
    raise AttributeError(name)


def register() -> None:
    from . import addon

    addon.register()


def unregister() -> None:
    from . import addon

    addon.unregister()
