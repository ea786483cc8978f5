"""Files of strangers: found where they may be read, bounded in size and depth, converted in processes that are bounded too."""
