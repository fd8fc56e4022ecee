"""Animation files: the dialog, what is to be exported, the formats, and the command line."""
