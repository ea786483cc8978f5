"""Node types of Acme's grippers: one file a family, all of which are found below the package that the entry point names."""
