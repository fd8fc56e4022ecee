"""A press by a pointer: its events, its fingertips, and their paths."""

from .poke import Hit as Hit
from .poke import Kind as Kind
from .poke import PokeEvent as PokeEvent
from .poke import PokeState as PokeState
from .poke import fingers as fingers
from .poke import lifted as lifted
from .poke import on_event as on_event
from .poke import with_settings as with_settings
