"""The laboratory, not shipped: scenes, methods that do not ship, what charts and tables are made of."""
