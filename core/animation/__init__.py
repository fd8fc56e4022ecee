"""An animation of vertices as files that numpy writes: point caches of other programs, textures of vertices."""
