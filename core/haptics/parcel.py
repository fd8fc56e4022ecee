"""What Blender gives to the body in the servo's process, and what comes back: a parcel now and then, a frame often.

A parcel is a list of changes, pickled, in a file of its own beside the mailbox; only arrays and the models of the core
can be in it. A frame is what a tick came to with the positions of all vertices, in a mailbox of its own size.
"""

from __future__ import annotations

import io
import pickle
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ..errors import DimpleError

if TYPE_CHECKING:
    from ..solver.motion import Frame

Change = tuple[Any, ...]  # the name of a method of `BodyHost`, then its arguments
SERVED: Final = ("base", "body", "material", "mesh", "reduction", "solver")  # rooms of the core that a parcel may name
NUMPY: Final = {"_reconstruct", "_frombuffer", "ndarray", "dtype", "scalar"}
FINGERS: Final = 3
_TOUCH: Final = struct.Struct("<B11dq")  # down, force, place, depth, outward, force of the law; triangle
_HEAD: Final = struct.Struct("<12d2dqB")  # pose, volume, pressure, parcel, finite
HEAD_SIZE: Final = FINGERS * _TOUCH.size + _HEAD.size


class _Reader(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        """Return a class of the core by the name it has here, an array's, or none."""
        from importlib import import_module

        own = module.rpartition("core.")[2] if "core." in module and not module.startswith("numpy") else ""
        if own.partition(".")[0] in SERVED:
            return getattr(import_module(f"{__package__.rpartition('.')[0]}.{own}"), name)
        if module.partition(".")[0] == "numpy" and name in NUMPY:
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name} is not a part of a body")


def pack_changes(changes: Sequence[Change]) -> bytes:
    """Return changes as bytes."""
    return pickle.dumps(list(changes), 5)


def unpack_changes(parcel: bytes) -> list[Change]:
    """Return the changes in a parcel.

    Raises:
        DimpleError: it is none, or has what a body has not.
    """
    try:
        return list(_Reader(io.BytesIO(parcel)).load())
    except (pickle.UnpicklingError, EOFError, AttributeError, ImportError, TypeError, ValueError, IndexError) as error:
        raise DimpleError(f"The body for the device cannot be read ({error}).") from None


def parcel_path(mailbox: Path, number: int) -> Path:
    """Return where a parcel lies."""
    return mailbox.with_name(f"{mailbox.name}.{number}")


def frame_size(vertices: int) -> int:
    """Return the bytes of a frame."""
    return HEAD_SIZE + 12 * vertices


def pack_frame(frame: Frame, forces: Sequence[Sequence[float]], parcel: int, positions: bytes) -> bytes:
    """Return a frame as bytes.

    Args:
        frame: of a tick.
        forces: on the fingertips, means since the frame before [N].
        parcel: number of the last that was taken.
        positions: (3, n) of the vertices in single precision [m].
    """
    parts = []
    for i in range(FINGERS):
        touch = frame.touches[i] if i < len(frame.touches) else None
        if touch is None:
            parts.append(bytes(_TOUCH.size))
            continue
        parts.append(
            _TOUCH.pack(True, *forces[i], *touch.centre, touch.depth, *touch.outward, touch.law_force, touch.triangle)
        )
    parts.append(_HEAD.pack(*frame.pose, frame.volume, frame.pressure, parcel, frame.finite))
    return b"".join([*parts, positions])


def unpack_frame(message: bytes) -> tuple[Frame, int, bytes]:
    """Return the frame in a message, the number of the last parcel before it, and the positions.

    The impulses of its touches are mean forces [N].
    """
    from ..solver.motion import Frame, Touch

    touches: list[Touch | None] = []
    for i in range(FINGERS):
        down, *v, triangle = _TOUCH.unpack_from(message, i * _TOUCH.size)
        touches.append(
            Touch((v[0], v[1], v[2]), (v[3], v[4], v[5]), v[6], (v[7], v[8], v[9]), v[10], triangle) if down else None
        )
    *pose, volume, pressure, parcel, finite = _HEAD.unpack_from(message, FINGERS * _TOUCH.size)
    return Frame(tuple(touches), tuple(pose), volume, pressure, 1, bool(finite)), parcel, message[HEAD_SIZE:]
