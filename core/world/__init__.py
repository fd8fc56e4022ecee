"""Bodies that meet each other, themselves, colliders, and props that fall."""

from ..native.scene import Collider as Collider
from .world import Meeting as Meeting
from .world import World as World
from .world import drop_proxies as drop_proxies
