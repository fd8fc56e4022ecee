"""Scenes and studies: the same scenes in tests, charts and samples."""
