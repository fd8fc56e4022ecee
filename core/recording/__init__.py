"""Files of moving surfaces: point caches (PC2), shape keys of few frames, vertex animation textures."""

from .point_cache import PointCache as PointCache
from .point_cache import open_point_cache as open_point_cache
