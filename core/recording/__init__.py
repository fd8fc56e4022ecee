"""Files of moving surfaces: point caches (PC2), a basis of few shape keys, vertex animation textures."""

from .point_cache import PointCache as PointCache
from .point_cache import open_point_cache as open_point_cache
