"""Animation files: the dialog, the export plan, the formats, and the command line."""
