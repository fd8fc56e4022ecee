"""Does nothing pass through anything? Twelve scenes, an independent referee, and what contact costs."""
