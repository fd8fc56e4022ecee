"""Contact of bodies with each other, with themselves, with colliders and with falling props."""

from ..native.scene import Collider as Collider
from .world import World as World
from .world import drop_proxies as drop_proxies
